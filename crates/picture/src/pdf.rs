//! Converts SVG to PDF: one page of curves, without fonts.

use crate::raster::PictureError;
use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::writers::ExtGraphicsState;
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, TextStr};
use resvg::usvg::tiny_skia_path::{Path as Outline, PathSegment, Point};
use resvg::usvg::{
    BlendMode, ClipPath, Color, Fill, FillRule, Group, LineCap, LineJoin, LinearGradient, Node, Options,
    Paint, Path, SpreadMethod, Stroke, Transform, Tree,
};

/// \[pt/px\] An inch is 72 points or 96 px.
const POINTS: f32 = 0.75;
/// \[pt\] Pages with longer sides need a unit larger than a point.
const LONGEST_SIDE: f32 = 14_400.0;
/// Number of strips of a gradient.
const STRIPS: usize = 128;
/// Level of zlib.
const COMPRESSION: u8 = 6;

const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const INFO: Ref = Ref::new(5);

/// Converts an SVG to a PDF of one page of the same size; 96 px are an inch. Curves remain curves.
///
/// # Errors
/// The text is not SVG, or it uses features that pictures of this crate do not: images, filters, masks, radial
/// gradients.
pub fn pdf(svg: &str) -> Result<Vec<u8>, PictureError> {
    let tree = Tree::from_str(svg, &Options::default())?;
    let (width, height) = (POINTS * tree.size().width(), POINTS * tree.size().height());
    let mut drawing = Drawing { content: Content::new(), opacities: Vec::new() };
    let unit = (width.max(height) / LONGEST_SIDE).ceil().max(1.0);
    let [scale, width, height] = [POINTS, width, height].map(|length| length / unit);
    drawing.content.transform([scale, 0.0, 0.0, -scale, 0.0, height]);
    drawing.group(tree.root())?;
    let Drawing { content, opacities } = drawing;

    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let mut page = pdf.page(PAGE);
    page.parent(PAGES).media_box(Rect::new(0.0, 0.0, width, height)).contents(CONTENT);
    if unit > 1.0 {
        page.user_unit(unit);
    }
    page.group().transparency().isolated(true).knockout(false).color_space().device_rgb();
    let mut resources = page.resources();
    let mut states = resources.ext_g_states();
    for (place, (fill, stroke)) in opacities.iter().enumerate() {
        let mut state = states.insert(Name(name(place).as_bytes())).start::<ExtGraphicsState>();
        state.non_stroking_alpha(*fill).stroking_alpha(*stroke);
    }
    states.finish();
    resources.finish();
    page.finish();
    pdf.stream(CONTENT, &compress_to_vec_zlib(&content.finish(), COMPRESSION)).filter(Filter::FlateDecode);
    // No date, so that the same picture gives the same bytes.
    pdf.document_info(INFO).producer(TextStr("LEMONS"));
    Ok(pdf.finish())
}

struct Drawing {
    content: Content,
    /// Opacities of fill and stroke, each pair once.
    opacities: Vec<(f32, f32)>,
}

/// Returns the name of opacities in the resources of the page.
fn name(place: usize) -> String {
    format!("O{place}")
}

impl Drawing {
    fn group(&mut self, group: &Group) -> Result<(), PictureError> {
        let plain = group.opacity().get() == 1.0
            && group.blend_mode() == BlendMode::Normal
            && group.mask().is_none()
            && group.filters().is_empty();
        if !plain {
            return Err(PictureError::Pdf("groups with an opacity, a mask or a filter"));
        }
        let own = !group.transform().is_identity() || group.clip_path().is_some();
        if own {
            self.content.save_state();
            self.content.transform(matrix(group.transform()));
        }
        if let Some(clip) = group.clip_path() {
            self.clip(clip)?;
        }
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group)?,
                Node::Path(path) if path.is_visible() => self.path(path)?,
                Node::Path(_) => {}
                Node::Image(_) | Node::Text(_) => return Err(PictureError::Pdf("images and text")),
            }
        }
        if own {
            self.content.restore_state();
        }
        Ok(())
    }

    /// Clips everything that is drawn after this.
    fn clip(&mut self, clip: &ClipPath) -> Result<(), PictureError> {
        if let Some(outer) = clip.clip_path() {
            self.clip(outer)?;
        }
        for node in clip.root().children() {
            let Node::Path(path) = node else { return Err(PictureError::Pdf("a clip of groups")) };
            let outline = path.data().clone().transform(clip.transform());
            outline.iter().for_each(|outline| self.outline(outline));
        }
        self.content.clip_nonzero().end_path();
        Ok(())
    }

    fn path(&mut self, path: &Path) -> Result<(), PictureError> {
        let mut opacity = (1.0, 1.0);
        let mut fill = path.fill();
        if let Some(Paint::LinearGradient(gradient)) = fill.map(Fill::paint) {
            self.shade(path.data(), gradient)?;
            fill = None;
        }
        if let Some(fill) = fill {
            let [r, g, b] = rgb(fill.paint())?;
            self.content.set_fill_rgb(r, g, b);
            opacity.0 = fill.opacity().get();
        }
        if let Some(stroke) = path.stroke() {
            self.pen(stroke)?;
            opacity.1 = stroke.opacity().get();
        }
        let place = self.opacities.iter().position(|known| *known == opacity).unwrap_or_else(|| {
            self.opacities.push(opacity);
            self.opacities.len() - 1
        });
        self.content.set_parameters(Name(name(place).as_bytes()));
        let even_odd = fill.is_some_and(|fill| fill.rule() == FillRule::EvenOdd);
        // One after the other: painted at once they would be one object, and a transparent stroke would not show the fill.
        if fill.is_some() {
            self.outline(path.data());
            if even_odd {
                self.content.fill_even_odd()
            } else {
                self.content.fill_nonzero()
            };
        }
        if path.stroke().is_some() {
            self.outline(path.data());
            self.content.stroke();
        }
        Ok(())
    }

    /// Fills an outline with a gradient from left to right: strips of one colour, each up to the end, so that there are
    /// no gaps between them.
    fn shade(&mut self, outline: &Outline, gradient: &LinearGradient) -> Result<(), PictureError> {
        let (stops, y) = (gradient.stops(), gradient.y1());
        let opaque = stops.iter().all(|stop| stop.opacity().get() == 1.0);
        if !opaque || gradient.spread_method() != SpreadMethod::Pad || stops.len() < 2 || y != gradient.y2() {
            return Err(PictureError::Pdf(
                "gradients that are transparent, repeated or not from left to right",
            ));
        }
        self.content.save_state();
        self.outline(outline);
        self.content.clip_nonzero().end_path().transform(matrix(gradient.transform()));
        let length = gradient.x2() - gradient.x1();
        for k in 0..STRIPS {
            let [begin, middle] = [0.0, 0.5].map(|part| (k as f32 + part) / STRIPS as f32);
            let above = stops.iter().position(|stop| stop.offset().get() >= middle);
            let above = above.unwrap_or(stops.len() - 1).max(1);
            let (a, b) = (&stops[above - 1], &stops[above]);
            let part = (middle - a.offset().get()) / (b.offset().get() - a.offset().get());
            let [from, to] = [a, b].map(|stop| parts(stop.color()));
            let mixed = |channel: usize| from[channel] + part.clamp(0.0, 1.0) * (to[channel] - from[channel]);
            self.content.set_fill_rgb(mixed(0), mixed(1), mixed(2));
            self.content.rect(gradient.x1() + begin * length, y - 1.0, (1.0 - begin) * length, 2.0);
            self.content.fill_nonzero();
        }
        self.content.restore_state();
        Ok(())
    }

    fn pen(&mut self, stroke: &Stroke) -> Result<(), PictureError> {
        let [r, g, b] = rgb(stroke.paint())?;
        // Pictures of this crate have no other ends and corners.
        let join = match stroke.linejoin() {
            LineJoin::Round => LineJoinStyle::RoundJoin,
            _ => LineJoinStyle::MiterJoin,
        };
        let cap = match stroke.linecap() {
            LineCap::Round => LineCapStyle::RoundCap,
            _ => LineCapStyle::ButtCap,
        };
        let dashes = stroke.dasharray().unwrap_or_default().iter().copied();
        let content = &mut self.content;
        content.set_stroke_rgb(r, g, b).set_line_width(stroke.width().get()).set_line_join(join);
        content.set_line_cap(cap).set_miter_limit(stroke.miterlimit().get());
        content.set_dash_pattern(dashes, stroke.dashoffset());
        Ok(())
    }

    fn outline(&mut self, outline: &Outline) {
        let (content, mut at) = (&mut self.content, Point::zero());
        for segment in outline.segments() {
            match segment {
                PathSegment::MoveTo(p) => content.move_to(p.x, p.y),
                PathSegment::LineTo(p) => content.line_to(p.x, p.y),
                PathSegment::QuadTo(c, p) => {
                    // PDF has cubic curves only.
                    let towards = |from: f32, to: f32| from + (to - from) * (2.0 / 3.0);
                    let [a, b] = [at, p].map(|end| (towards(end.x, c.x), towards(end.y, c.y)));
                    content.cubic_to(a.0, a.1, b.0, b.1, p.x, p.y)
                }
                PathSegment::CubicTo(a, b, p) => content.cubic_to(a.x, a.y, b.x, b.y, p.x, p.y),
                PathSegment::Close => content.close_path(),
            };
            if let PathSegment::MoveTo(p)
            | PathSegment::LineTo(p)
            | PathSegment::QuadTo(_, p)
            | PathSegment::CubicTo(_, _, p) = segment
            {
                at = p;
            }
        }
    }
}

fn rgb(paint: &Paint) -> Result<[f32; 3], PictureError> {
    match paint {
        Paint::Color(colour) => Ok(parts(*colour)),
        _ => Err(PictureError::Pdf("gradients and patterns")),
    }
}

fn parts(colour: Color) -> [f32; 3] {
    // Three decimals distinguish all 256 values, and are short.
    [colour.red, colour.green, colour.blue].map(|part| (f32::from(part) / 0.255).round() / 1000.0)
}

fn matrix(t: Transform) -> [f32; 6] {
    [t.sx, t.ky, t.kx, t.sy, t.tx, t.ty]
}
