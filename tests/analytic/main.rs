//! The engine against closed forms, conservation laws and independently integrated values.

mod collision;
mod friction;
mod shortlist;
mod support;
mod walls;
