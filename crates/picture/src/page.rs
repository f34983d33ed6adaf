//! A page, and what is on it beside scenes and curves: texts, legend, scale bar, colour bar.

use crate::colour::{Colour, Palette, Theme};
use crate::glyphs::{self, END, MIDDLE, PEN, START, TextPlace};
use crate::style::Scale;
use crate::text::{PX, escaped, in_units, round_below, short, text_of};

/// \[px\] Page width at which lines and letters have their nominal sizes in px.
pub(crate) const NOMINAL_WIDTH: f64 = 400.0;
/// \[px\] Margin around everything.
pub(crate) const MARGIN: f64 = 14.0;
/// \[px\] Height of capital letters.
pub(crate) const CAP_HEIGHT: f64 = 7.5;
/// \[px\] Gap between the scene and elements above or below it.
pub(crate) const BAND_GAP: f64 = 12.0;
/// \[px\] Dash and gap of measured lines.
const DASH: (f64, f64) = (4.2, 3.4);
/// \[px\] Border of paper around each dash. So dashes are visible on a solid line of their colour, and that line
/// between the dashes.
pub(crate) const CASING: f64 = 0.9;
/// \[px\] Length of a line in a legend.
const SAMPLE: f64 = 24.0;
/// \[px\] Distance between a line of a legend and its text.
const SAMPLE_GAP: f64 = 6.0;
/// \[px\] Distance between entries of a legend.
const ENTRY_GAP: f64 = 16.0;
/// \[px\] Distance between rows of a legend.
const ROW: f64 = CAP_HEIGHT + 9.0;

/// Returns a width that can be drawn.
pub(crate) fn page_width(asked: f64) -> f64 {
    if asked.is_finite() { asked.clamp(32.0, 32_768.0) } else { NOMINAL_WIDTH }
}

/// Returns, as SVG, the dashes of the border and those of the measured line; `px` is one pixel.
pub(crate) fn dashes(px: f64) -> [String; 2] {
    let pattern = |dash: f64, gap: f64, begun: f64| {
        let [dash, gap, begun] = [dash, gap, begun].map(|v| text_of(v * px, 6));
        format!(" stroke-linecap=\"butt\" stroke-dasharray=\"{dash} {gap}\" stroke-dashoffset=\"{begun}\"")
    };
    [pattern(DASH.0 + 2.0 * CASING, DASH.1 - 2.0 * CASING, CASING), pattern(DASH.0, DASH.1, 0.0)]
}

/// Writes a path, if there is any; `more` is its further attributes, each after a space.
pub(crate) fn path(out: &mut String, class: &str, colour: Colour, width: &str, more: &str, d: &str) {
    if !d.is_empty() {
        *out += &format!(
            "<path class=\"{class}\" stroke=\"{colour}\" stroke-width=\"{width}\"{more} d=\"{d}\"/>\n"
        );
    }
}

/// A page that is being drawn, in px.
pub(crate) struct Page {
    /// The SVG.
    pub out: String,
    pub palette: Palette,
    /// Scale of everything that is not drawn to scale.
    pub unit: f64,
    pub width: f64,
    height: f64,
}

impl Page {
    /// Begins the page and fills it with the colour of the paper.
    pub fn begin(title: &str, theme: Theme, unit: f64, width: f64, height: f64) -> Page {
        let (palette, [w, h]) = (Palette::of(theme), [width, height].map(|v| text_of(v, PX)));
        let out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" role=\"img\">\n\
             <title>{}</title>\n<rect width=\"{w}\" height=\"{h}\" fill=\"{}\"/>\n",
            escaped(title),
            palette.paper
        );
        Page { out, palette, unit, width, height }
    }

    /// Ends the page and returns it as SVG.
    pub fn end(self) -> String {
        self.out + "</svg>\n"
    }

    /// Draws a line; `more` is its further attributes, each after a space.
    pub fn line(&mut self, class: &str, colour: Colour, width: &str, more: &str, d: &str) {
        self.out += &format!(
            "<path class=\"{class}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{more} d=\"{d}\"/>\n"
        );
    }

    /// Returns a place for text of the one size beside scenes.
    pub fn place(&self, x: f64, y: f64, anchor: f64) -> TextPlace {
        TextPlace { x, y, cap_height: CAP_HEIGHT * self.unit, anchor, up: -1.0, decimals: PX }
    }

    /// Draws text beside the scene.
    pub fn text(&mut self, class: &str, text: &str, place: TextPlace) {
        self.text_of_colour(class, text, place, self.palette.ink);
    }

    /// Draws text of a colour, with a label for readers that cannot see strokes.
    pub fn text_of_colour(&mut self, class: &str, text: &str, place: TextPlace, colour: Colour) {
        let mut d = String::new();
        glyphs::strokes(&mut d, text, place);
        self.out += &format!(
            "<path class=\"{class}\" aria-label=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\" \
             stroke-linecap=\"round\" stroke-linejoin=\"round\" d=\"{d}\"/>\n",
            escaped(text),
            text_of(PEN * place.cap_height, PX)
        );
    }

    /// Draws a bar of a round length at the lower left; `scale` is in px/m.
    pub fn scale_bar(&mut self, scale: f64, room: f64) {
        let metres = round_below(room / scale);
        let label = in_units(metres, &[(1000.0, "km"), (1.0, "m"), (0.01, "cm"), (0.001, "mm")]);
        let cap = CAP_HEIGHT * self.unit;
        let (y, x0) = (self.height - MARGIN * self.unit - 0.5 * cap, MARGIN * self.unit);
        let (x1, tick) = (x0 + metres * scale, 0.42 * cap);
        let [ax, bx, up, mid, down] = [x0, x1, y - tick, y, y + tick].map(|v| text_of(v, PX));
        let d = format!("M{ax} {up}V{down}M{ax} {mid}H{bx}M{bx} {up}V{down}");
        self.line("scale-bar", self.palette.ink, &text_of(1.2 * self.unit, PX), "", &d);
        self.text("scale", &label, self.place(x1 + 0.9 * cap, y + 0.5 * cap, START));
    }

    /// Draws the colour map with its ends and its meaning at the lower right, or words if there is no colour bar.
    pub fn colour_bar(&mut self, scale: &Scale) {
        let Scale { title, low, high, ramp, .. } = scale;
        let (cap, right) = (CAP_HEIGHT * self.unit, self.width - MARGIN * self.unit);
        let y = self.height - MARGIN * self.unit;
        if let Some(words) = &scale.nothing {
            // Long ones are above the scale bar, and not across it.
            let long = glyphs::width(words, cap) > 0.55 * self.width;
            let y = if long { y - 1.9 * cap } else { y };
            return self.text("label", words, self.place(right, y, END));
        }
        let (bar, space) = (120.0 * self.unit, 0.8 * cap);
        let number = if low == high { short(*high) } else { scale.high_label() };
        let x1 = right - (glyphs::width(&number, cap) + space);
        let x0 = x1 - bar;
        let last = ramp.0.len() - 1;
        let stop = |(k, colour)| {
            let offset = text_of(k as f64 / last as f64, 4);
            format!("<stop offset=\"{offset}\" stop-color=\"{colour}\"/>")
        };
        let stops: String = ramp.0.iter().enumerate().map(stop).collect();
        let fill = if low == high { ramp.at(0.5).to_string() } else { "url(#colours)".to_owned() };
        let [x, top, w, h, r] = [x0, y - cap, bar, cap, 0.2 * cap].map(|v| text_of(v, PX));
        self.out += &format!(
            "<g class=\"colour-bar\">\n<linearGradient id=\"colours\">{stops}</linearGradient>\n\
             <rect x=\"{x}\" y=\"{top}\" width=\"{w}\" height=\"{h}\" rx=\"{r}\" fill=\"{fill}\"/>\n"
        );
        if low != high {
            self.text("low", &scale.low_label(), self.place(x0 - space, y, END));
        }
        self.text("high", &number, self.place(x1 + space, y, START));
        // A title longer than the bar is centred on it while there is room, then it shrinks.
        let length = glyphs::width(title, cap);
        let shrink = shrunk(length, self.width - 2.0 * MARGIN * self.unit);
        let x = (0.5 * (x0 + x1)).min(right - 0.5 * length * shrink);
        let place = self.place(x, y - 1.9 * cap, MIDDLE);
        self.text("label", title, TextPlace { cap_height: cap * shrink, ..place });
        self.out += "</g>\n";
    }
}

/// Returns the factor that makes a length not longer than the room.
pub(crate) fn shrunk(length: f64, room: f64) -> f64 {
    (room / length.max(1e-9)).min(1.0)
}

/// \[px\] Height of scale bar and colour bar, including the gap above them.
pub(crate) fn footer_height(colour_bar: bool) -> f64 {
    BAND_GAP + if colour_bar { 2.4 * CAP_HEIGHT + 2.0 } else { CAP_HEIGHT }
}

/// An entry of a legend: a line and its meaning.
pub(crate) struct Entry {
    pub class: &'static str,
    pub label: String,
    pub colour: Colour,
    /// \[px\] Width of the line.
    pub width: f64,
    /// A halo around the line, with its width on each side \[px\].
    pub halo: Option<(Colour, f64)>,
    pub dashed: bool,
}

impl Entry {
    /// Returns the entries of simulated (solid) and measured (dashed) lines of a width.
    pub fn simulated_and_measured(palette: &Palette, width: f64) -> [Entry; 2] {
        [("simulated", false), ("measured", true)].map(|(class, dashed)| {
            let label = class.to_owned();
            Entry { class, label, colour: palette.ink, width, halo: None, dashed }
        })
    }

    /// Draws the entry and returns the x of its end.
    fn draw(&self, page: &mut Page, x: f64, base: f64) -> f64 {
        let (unit, cap) = (page.unit, CAP_HEIGHT * page.unit);
        // Round line ends extend beyond the line.
        let end = if self.dashed { 0.0 } else { 0.5 * self.width + self.halo.map_or(0.0, |h| h.1) };
        let [x0, x1, y] = [x + end, x + SAMPLE * unit - end, base - 0.5 * cap].map(|v| text_of(v, PX));
        let d = format!("M{x0} {y}H{x1}");
        let round = " stroke-linecap=\"round\"";
        if let Some((colour, around)) = self.halo {
            page.line("halo", colour, &text_of(self.width + 2.0 * around, 3), round, &d);
        }
        let [dash, gap] = [DASH.0 * unit, DASH.1 * unit].map(|v| text_of(v, PX));
        let dashes = format!(" stroke-dasharray=\"{dash} {gap}\"");
        let more = if self.dashed { &dashes } else { round };
        page.line(self.class, self.colour, &text_of(self.width, 3), more, &d);
        let x = x + (SAMPLE + SAMPLE_GAP) * unit;
        page.text("entry", &self.label, page.place(x, base, START));
        x + glyphs::width(&self.label, cap)
    }
}

/// Elements above a scene, laid out in rows.
pub(crate) struct Header {
    /// For each row, the x at which its first entry begins \[px\], and its entries.
    rows: Vec<(f64, Vec<Entry>)>,
    /// \[px\] Height of the rows and the gap below them; 0 if there are none.
    pub height: f64,
}

impl Header {
    /// Places the legend right of the time, or in rows below it if there is no room. No time is empty.
    pub fn new(time: &str, legend: Vec<Entry>, unit: f64, width: f64) -> Header {
        let (left, room) = (MARGIN * unit, width - 2.0 * MARGIN * unit);
        let length = |e: &Entry| (SAMPLE + SAMPLE_GAP) * unit + glyphs::width(&e.label, CAP_HEIGHT * unit);
        let gap = ENTRY_GAP * unit;
        let whole: f64 = legend.iter().map(|e| length(e) + gap).sum::<f64>() - gap;
        let beside = if time.is_empty() { 0.0 } else { glyphs::width(time, CAP_HEIGHT * unit) + gap };
        if time.is_empty() && legend.is_empty() {
            return Header { rows: Vec::new(), height: 0.0 };
        }
        let fits = whole + beside <= room;
        let mut rows = vec![(if fits { left + room - whole.max(0.0) } else { left }, Vec::new())];
        let mut used = if fits || time.is_empty() { 0.0 } else { f64::INFINITY };
        for entry in legend {
            let more = length(&entry);
            match rows.last_mut() {
                Some((_, row)) if fits || used == 0.0 || used + more <= room => row.push(entry),
                _ => {
                    rows.push((left, vec![entry]));
                    used = 0.0;
                }
            }
            used += more + gap;
        }
        let height = (CAP_HEIGHT + (rows.len() - 1) as f64 * ROW + BAND_GAP) * unit;
        Header { rows, height }
    }

    /// Draws the legend. The caller draws the time, because its place may differ.
    pub fn draw(&self, page: &mut Page) {
        if self.rows.iter().all(|(_, row)| row.is_empty()) {
            return;
        }
        page.out += "<g class=\"legend\">\n";
        for (k, (start, row)) in self.rows.iter().enumerate() {
            let base = MARGIN * page.unit + (CAP_HEIGHT + k as f64 * ROW) * page.unit;
            row.iter().fold(*start, |x, entry| entry.draw(page, x, base) + ENTRY_GAP * page.unit);
        }
        page.out += "</g>\n";
    }
}
