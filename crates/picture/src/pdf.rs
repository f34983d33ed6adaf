//! Converts SVG to PDF: one page of curves, without fonts. Documents of pages with text, and such pictures.

use crate::raster::PictureError;
use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::writers::ExtGraphicsState;
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
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
/// \[pt\] An A4 page.
pub const A4: [f32; 2] = [595.0, 842.0];
/// Names of the fonts: those that every reader of PDF has.
const FONTS: [(&[u8], &[u8]); 2] = [(b"F0", b"Helvetica"), (b"F1", b"Helvetica-Bold")];

/// A page of a document: what is on it, in points from the upper left corner.
#[derive(Debug, Clone, Default)]
pub struct PdfPage {
    /// Texts.
    pub texts: Vec<PdfText>,
    /// Thin lines: the left end, the height, the right end.
    pub lines: Vec<[f32; 3]>,
    /// Pictures: left, upper end, width, SVG.
    pub pictures: Vec<([f32; 3], String)>,
}

/// A text in one line.
#[derive(Debug, Clone, Default)]
pub struct PdfText {
    /// Where it begins, on its base line.
    pub at: [f32; 2],
    /// Size of its letters.
    pub size: f32,
    /// Whether they are bold.
    pub bold: bool,
    /// Whether they are paler.
    pub soft: bool,
    /// The text. Letters that the font does not have become `?`.
    pub text: String,
}

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
    Ok(written(vec![content], [width, height], unit, &opacities, None))
}

/// Makes a document of A4 pages, whose text can be selected.
///
/// # Errors
/// Those of [`pdf`], of a picture.
pub fn document(title: &str, pages: &[PdfPage]) -> Result<Vec<u8>, PictureError> {
    let mut drawing = Drawing { content: Content::new(), opacities: Vec::new() };
    let mut contents = Vec::new();
    for PdfPage { texts, lines, pictures } in pages {
        for ([left, top, width], svg) in pictures {
            let tree = Tree::from_str(svg, &Options::default())?;
            let scale = width / tree.size().width();
            drawing.content.save_state().transform([scale, 0.0, 0.0, -scale, *left, A4[1] - top]);
            drawing.group(tree.root())?;
            drawing.content.restore_state();
        }
        let content = &mut drawing.content;
        content.set_stroke_rgb(0.8, 0.83, 0.86).set_line_width(0.5);
        for [left, height, right] in lines {
            content.move_to(*left, A4[1] - height).line_to(*right, A4[1] - height).stroke();
        }
        for PdfText { at: [x, y], size, bold, soft, text } in texts {
            let [r, g, b] = if *soft { [0.36, 0.4, 0.46] } else { [0.11, 0.15, 0.2] };
            content.set_fill_rgb(r, g, b).begin_text().set_font(Name(FONTS[usize::from(*bold)].0), *size);
            content.next_line(*x, A4[1] - y).show(Str(&encoded(text))).end_text();
        }
        contents.push(std::mem::replace(content, Content::new()));
    }
    Ok(written(contents, A4, 1.0, &drawing.opacities, Some(title)))
}

/// Returns a document of pages of one size; with fonts if it has a title.
fn written(
    pages: Vec<Content>,
    [width, height]: [f32; 2],
    unit: f32,
    opacities: &[(f32, f32)],
    title: Option<&str>,
) -> Vec<u8> {
    let of = |k: usize| Ref::new(3 + k as i32);
    let mut pdf = Pdf::new();
    let mut catalog = pdf.catalog(CATALOG);
    catalog.pages(PAGES);
    if title.is_some() {
        catalog.lang(TextStr("en")).viewer_preferences().display_doc_title(true);
    }
    catalog.finish();
    pdf.pages(PAGES).kids((0..pages.len()).map(|k| of(2 * k))).count(pages.len() as i32);
    let after = 2 * pages.len();
    for (k, content) in pages.into_iter().enumerate() {
        let mut page = pdf.page(of(2 * k));
        page.parent(PAGES).media_box(Rect::new(0.0, 0.0, width, height)).contents(of(2 * k + 1));
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
        if title.is_some() {
            let mut fonts = resources.fonts();
            FONTS.iter().enumerate().for_each(|(k, font)| {
                fonts.pair(Name(font.0), of(after + 1 + k));
            });
        }
        resources.finish();
        page.finish();
        let content = compress_to_vec_zlib(&content.finish(), COMPRESSION);
        pdf.stream(of(2 * k + 1), &content).filter(Filter::FlateDecode);
    }
    // No date, so that the same picture gives the same bytes.
    let mut info = pdf.document_info(of(after));
    info.producer(TextStr("LEMONS"));
    if let Some(title) = title {
        info.title(TextStr(title));
        info.finish();
        for (k, (_, font)) in FONTS.iter().enumerate() {
            let mut of = pdf.type1_font(of(after + 1 + k));
            of.base_font(Name(font)).encoding_predefined(Name(b"WinAnsiEncoding"));
        }
    } else {
        info.finish();
    }
    pdf.finish()
}

/// \[1/1000\] Widths of the letters from the space to the tilde in Helvetica.
const WIDTHS: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556, 556, 556,
    556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667, 611, 778, 722, 278,
    500, 667, 556, 833, 722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469,
    556, 333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500,
    278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
];

/// \[pt\] Returns the width of a text; of bold text and rare letters a little too much.
pub fn text_width(text: &str, size: f32, bold: bool) -> f32 {
    let width =
        |byte: u8| byte.checked_sub(b' ').and_then(|k| WIDTHS.get(usize::from(k))).copied().unwrap_or(600);
    let sum: f32 = encoded(text).into_iter().map(|byte| f32::from(width(byte))).sum();
    sum * size * if bold { 1.08 } else { 1.0 } / 1000.0
}

/// Returns a text in the encoding of the fonts.
fn encoded(text: &str) -> Vec<u8> {
    let byte = |c: char| match c {
        ' '..='~' | '\u{a0}'..='\u{ff}' => c as u8,
        '…' => 0x85,
        '‘' => 0x91,
        '’' => 0x92,
        '“' => 0x93,
        '”' => 0x94,
        '•' => 0x95,
        '–' => 0x96,
        '—' => 0x97,
        '−' => b'-',
        '\n' | '\t' => b' ',
        _ => b'?',
    };
    text.chars().map(byte).collect()
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
