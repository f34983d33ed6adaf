//! Converts SVG to PDF: one page of curves, without fonts.

use crate::raster::PictureError;
use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{FunctionShadingType, LineCapStyle, LineJoinStyle};
use pdf_writer::writers::ExtGraphicsState;
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, TextStr};
use resvg::usvg::tiny_skia_path::{Path as Outline, PathSegment, Point};
use resvg::usvg::{
    BlendMode, ClipPath, Color, Fill, FillRule, Group, LineCap, LineJoin, LinearGradient, Node, Options,
    Paint, Path, SpreadMethod, Stop, Stroke, Transform, Tree,
};

/// \[pt/px\] An inch is 72 points or 96 px.
const POINTS: f32 = 0.75;
/// \[pt\] Pages with longer sides need a unit larger than a point.
const LONGEST_SIDE: f32 = 14_400.0;
/// Level of zlib.
const COMPRESSION: u8 = 6;

const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const INFO: Ref = Ref::new(5);
const FIRST_FREE: i32 = 6;

/// Converts an SVG to a PDF of one page of the same size; 96 px are an inch. Curves remain curves.
///
/// # Errors
/// The text is not SVG, or it uses features that pictures of this crate do not: images, filters, masks, radial
/// gradients.
pub fn pdf(svg: &str) -> Result<Vec<u8>, PictureError> {
    let tree = Tree::from_str(svg, &Options::default())?;
    let (width, height) = (POINTS * tree.size().width(), POINTS * tree.size().height());
    let unit = (width.max(height) / LONGEST_SIDE).ceil().max(1.0);
    let mut drawing = Drawing { content: Content::new(), opacities: Vec::new(), shadings: Vec::new() };
    let scale = POINTS / unit;
    drawing.content.transform([scale, 0.0, 0.0, -scale, 0.0, height / unit]);
    drawing.group(tree.root())?;
    let Drawing { content, opacities, shadings } = drawing;

    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let mut page = pdf.page(PAGE);
    page.parent(PAGES).media_box(Rect::new(0.0, 0.0, width / unit, height / unit)).contents(CONTENT);
    if unit > 1.0 {
        page.user_unit(unit);
    }
    page.group().transparency().isolated(true).knockout(false).color_space().device_rgb();
    let mut resources = page.resources();
    let mut states = resources.ext_g_states();
    for (place, (fill, stroke)) in opacities.iter().enumerate() {
        let mut state = states.insert(Name(name('O', place).as_bytes())).start::<ExtGraphicsState>();
        state.non_stroking_alpha(*fill).stroking_alpha(*stroke);
    }
    states.finish();
    // The function of a shading follows it.
    let objects = || (FIRST_FREE..).step_by(2).map(Ref::new).zip(&shadings);
    let mut places = resources.shadings();
    for (place, (object, _)) in objects().enumerate() {
        places.pair(Name(name('S', place).as_bytes()), object);
    }
    places.finish();
    resources.finish();
    page.finish();
    pdf.stream(CONTENT, &compress_to_vec_zlib(&content.finish(), COMPRESSION)).filter(Filter::FlateDecode);
    objects().for_each(|(object, shading)| shading.write(&mut pdf, object));
    // No date, so that the same picture gives the same bytes.
    pdf.document_info(INFO).producer(TextStr("LEMONS"));
    Ok(pdf.finish())
}

struct Drawing {
    content: Content,
    /// Opacities of fill and stroke, each pair once.
    opacities: Vec<(f32, f32)>,
    shadings: Vec<Shading>,
}

/// A linear gradient.
struct Shading {
    /// x and y of both ends.
    line: [f32; 4],
    /// Colours at equal distances from one end to the other.
    colours: Vec<Color>,
}

/// Returns the name of an object of the page: O for opacities, S for shadings.
fn name(kind: char, place: usize) -> String {
    format!("{kind}{place}")
}

impl Shading {
    /// Writes the shading and, as the next object, its function.
    fn write(&self, pdf: &mut Pdf, object: Ref) {
        let function = Ref::new(object.get() + 1);
        let mut shading = pdf.function_shading(object);
        shading.shading_type(FunctionShadingType::Axial).color_space().device_rgb();
        shading.coords(self.line).function(function).extend([true, true]);
        shading.finish();
        let samples: Vec<u8> = self.colours.iter().flat_map(|c| [c.red, c.green, c.blue]).collect();
        let mut colours = pdf.sampled_function(function, &samples);
        colours.domain([0.0, 1.0]).range([0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
        colours.size([self.colours.len() as i32]).bits_per_sample(8);
    }
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
        self.content.set_parameters(Name(name('O', place).as_bytes()));
        let even_odd = fill.is_some_and(|fill| fill.rule() == FillRule::EvenOdd);
        // Painting both at once would make them one object: a transparent stroke would not show the fill.
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

    /// Fills an outline with a gradient.
    fn shade(&mut self, outline: &Outline, gradient: &LinearGradient) -> Result<(), PictureError> {
        let stops = gradient.stops();
        let plain = |(k, stop): (usize, &Stop)| {
            let place = k as f32 / (stops.len() - 1) as f32;
            stop.opacity().get() == 1.0 && (stop.offset().get() - place).abs() < 1e-3
        };
        let even = stops.len() > 1 && stops.iter().enumerate().all(plain);
        if !even || gradient.spread_method() != SpreadMethod::Pad {
            return Err(PictureError::Pdf("gradients that are transparent, uneven or repeated"));
        }
        let name = name('S', self.shadings.len());
        let line = [gradient.x1(), gradient.y1(), gradient.x2(), gradient.y2()];
        self.shadings.push(Shading { line, colours: stops.iter().map(Stop::color).collect() });
        self.content.save_state();
        self.outline(outline);
        self.content.clip_nonzero().end_path().transform(matrix(gradient.transform()));
        self.content.shading(Name(name.as_bytes())).restore_state();
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
        // Three decimals distinguish all 256 values, and are short.
        Paint::Color(Color { red, green, blue }) => {
            Ok([*red, *green, *blue].map(|part| (f32::from(part) / 0.255).round() / 1000.0))
        }
        _ => Err(PictureError::Pdf("gradients and patterns")),
    }
}

fn matrix(t: Transform) -> [f32; 6] {
    [t.sx, t.ky, t.kx, t.sy, t.tx, t.ty]
}
