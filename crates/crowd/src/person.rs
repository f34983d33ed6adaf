//! A person by four measures.

/// Whose statistics a person is drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Sex {
    /// A man.
    Male,
    /// A woman.
    Female,
}

/// What a two-dimensional shape and a three-dimensional body follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Person {
    /// Whose statistics it comes from.
    pub sex: Sex,
    /// \[m\] bideltoid breadth: across the shoulders.
    pub breadth: f64,
    /// \[m\] chest depth.
    pub depth: f64,
    /// \[m\] height without shoes.
    pub stature: f64,
    /// \[kg\]
    pub mass: f64,
}
