//! Elements beside a scene: time, legend, scale bar, colour bar.

use crate::colour::{Colour, Palette};
use crate::colouring::Scale;
use crate::lettering::{self, Anchor, PEN, Place, Up};
use crate::look::DASH;
use crate::page::{BAND_GAP, CAP_HEIGHT, MARGIN, Page};
use crate::text::{PX, escaped, round_below, short, text_of};

/// \[px\] Length of a line in a legend.
const SAMPLE: f64 = 24.0;
/// \[px\] Distance between a line of a legend and its text.
const SAMPLE_GAP: f64 = 6.0;
/// \[px\] Distance between entries of a legend.
const ENTRY_GAP: f64 = 16.0;
/// \[px\] Distance between rows of a header.
const ROW: f64 = CAP_HEIGHT + 9.0;

/// An entry of a legend: a line and its meaning.
pub(crate) struct Entry {
    pub class: &'static str,
    pub label: String,
    pub colour: Colour,
    /// \[px\] Width of the line.
    pub width: f64,
    /// A halo around the line, with its width on each side \[px\].
    pub halo: Option<(Colour, f64)>,
    /// \[px\] Dash and gap.
    pub dash: Option<(f64, f64)>,
}

/// Elements above a scene, laid out in rows.
pub(crate) struct Header {
    /// For each row, the x at which its first entry begins \[px\], and its entries.
    rows: Vec<(f64, Vec<Entry>)>,
    /// \[px\] Height of the rows and the gap below them; 0 if there are none.
    pub height: f64,
}

impl Header {
    /// Places the legend right of the time stamp, or in rows below it if there is no room.
    pub fn new(time: Option<&str>, legend: Vec<Entry>, unit: f64, width: f64) -> Header {
        let (left, room) = (MARGIN * unit, width - 2.0 * MARGIN * unit);
        let length = |e: &Entry| (SAMPLE + SAMPLE_GAP) * unit + lettering::width(&e.label, CAP_HEIGHT * unit);
        let gap = ENTRY_GAP * unit;
        let whole: f64 = legend.iter().map(|e| length(e) + gap).sum::<f64>() - gap;
        let beside = time.map_or(0.0, |t| lettering::width(t, CAP_HEIGHT * unit) + gap);
        let mut rows = Vec::new();
        if time.is_some() || !legend.is_empty() {
            rows.push((left, Vec::new()));
        }
        if whole + beside <= room {
            if let Some(first) = rows.first_mut() {
                *first = (left + room - whole.max(0.0), legend);
            }
        } else {
            let mut used = if time.is_some() { f64::INFINITY } else { 0.0 };
            for entry in legend {
                let more = length(&entry);
                if used > 0.0 && used + more > room {
                    rows.push((left, Vec::new()));
                    used = 0.0;
                }
                used += more + gap;
                if let Some((_, row)) = rows.last_mut() {
                    row.push(entry);
                }
            }
        }
        let height = match rows.len() {
            0 => 0.0,
            n => (CAP_HEIGHT + (n - 1) as f64 * ROW + BAND_GAP) * unit,
        };
        Header { rows, height }
    }

    /// Draws the legend. The caller draws the time, because its place may differ.
    pub fn draw(&self, out: &mut String, page: &Page, palette: &Palette, top: f64) {
        if self.rows.iter().all(|(_, row)| row.is_empty()) {
            return;
        }
        *out += "<g class=\"legend\">\n";
        for (k, (start, row)) in self.rows.iter().enumerate() {
            let base = top + (CAP_HEIGHT + k as f64 * ROW) * page.unit;
            let mut x = *start;
            for entry in row {
                x = entry.draw(out, page, palette, x, base) + ENTRY_GAP * page.unit;
            }
        }
        *out += "</g>\n";
    }
}

impl Entry {
    /// A solid line in the colour of text, named after its class.
    pub fn of_line(class: &'static str, palette: &Palette, width: f64) -> Entry {
        Entry { class, label: class.to_owned(), colour: palette.ink, width, halo: None, dash: None }
    }

    pub fn dashed(self, unit: f64) -> Entry {
        Entry { dash: Some((DASH.0 * unit, DASH.1 * unit)), ..self }
    }

    /// Draws the entry and returns the x of its end.
    fn draw(&self, out: &mut String, page: &Page, palette: &Palette, x: f64, base: f64) -> f64 {
        let (unit, cap) = (page.unit, CAP_HEIGHT * page.unit);
        // Round line ends extend beyond the line.
        let end = self.dash.map_or(0.5 * self.width + self.halo.map_or(0.0, |h| h.1), |_| 0.0);
        let [x0, x1, y] = [x + end, x + SAMPLE * unit - end, base - 0.5 * cap].map(|v| text_of(v, PX));
        let line = |out: &mut String, class: &str, colour: Colour, width: f64, more: &str| {
            let width = text_of(width, 3);
            *out += &format!(
                "<path class=\"{class}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{more} d=\"M{x0} {y}H{x1}\"/>\n"
            );
        };
        let round = " stroke-linecap=\"round\"";
        if let Some((colour, around)) = self.halo {
            line(out, "halo", colour, self.width + 2.0 * around, round);
        }
        match self.dash {
            Some((dash, gap)) => {
                let dashes = format!(" stroke-dasharray=\"{} {}\"", text_of(dash, PX), text_of(gap, PX));
                line(out, self.class, self.colour, self.width, &dashes);
            }
            None => line(out, self.class, self.colour, self.width, round),
        }
        let x = x + (SAMPLE + SAMPLE_GAP) * unit;
        lettered(out, "entry", &self.label, Place { x, y: base, ..small(unit, Anchor::Start) }, palette.ink);
        x + lettering::width(&self.label, cap)
    }
}

/// \[px\] Height of scale bar and colour bar, including the gap above them.
pub(crate) fn footer_height(colour_bar: bool) -> f64 {
    BAND_GAP + if colour_bar { 2.4 * CAP_HEIGHT + 2.0 } else { CAP_HEIGHT }
}

/// Draws a bar of a round length at the lower left; `scale` is in px/m.
pub(crate) fn scale_bar(out: &mut String, page: &Page, palette: &Palette, scale: f64, room: f64) {
    let metres = round_below(room / scale);
    let label = if metres >= 1000.0 {
        format!("{} km", metres / 1000.0)
    } else if metres >= 1.0 {
        format!("{metres} m")
    } else if metres >= 0.01 {
        format!("{} cm", (metres * 100.0).round())
    } else {
        format!("{} mm", (metres * 1e4).round() / 10.0)
    };
    let cap = CAP_HEIGHT * page.unit;
    let (y, x0) = (page.height - MARGIN * page.unit - 0.5 * cap, MARGIN * page.unit);
    let (x1, tick) = (x0 + metres * scale, 0.42 * cap);
    let [ax, bx, up, mid, down] = [x0, x1, y - tick, y, y + tick].map(|v| text_of(v, PX));
    *out += &format!(
        "<path class=\"scale-bar\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" d=\"M{ax} {up}V{down}M{ax} {mid}H{bx}M{bx} {up}V{down}\"/>\n",
        palette.ink,
        text_of(1.2 * page.unit, PX)
    );
    let place = Place { x: x1 + 0.9 * cap, y: y + 0.5 * cap, ..small(page.unit, Anchor::Start) };
    lettered(out, "scale", &label, place, palette.ink);
}

/// Draws the colour map with its ends and its meaning at the lower right, or words if there is no colour bar.
pub(crate) fn colour_bar(out: &mut String, page: &Page, palette: &Palette, scale: &Scale) {
    let Scale { title, low, high, ramp, .. } = scale;
    let (cap, right) = (CAP_HEIGHT * page.unit, page.width - MARGIN * page.unit);
    let y = page.height - MARGIN * page.unit;
    if let Some(words) = &scale.nothing {
        // Long ones are above the scale bar, and not across it.
        let long = lettering::width(words, cap) > 0.55 * page.width;
        let y = if long { y - 1.9 * cap } else { y };
        let place = Place { x: right, y, ..small(page.unit, Anchor::End) };
        return lettered(out, "label", words, place, palette.ink);
    }
    let numbers =
        if low == high { [None, Some(short(*high))] } else { [Some(short(*low)), Some(scale.high_label())] };
    let space = 0.8 * cap;
    let length_of = |t: &Option<String>| t.as_ref().map_or(0.0, |t| lettering::width(t, cap) + space);
    let bar = 120.0 * page.unit;
    let x1 = right - length_of(&numbers[1]);
    let x0 = x1 - bar;

    *out += "<g class=\"colour-bar\">\n<linearGradient id=\"colours\">";
    for (k, colour) in ramp.colours().iter().enumerate() {
        let offset = text_of(k as f64 / (ramp.colours().len() - 1) as f64, 4);
        *out += &format!("<stop offset=\"{offset}\" stop-color=\"{colour}\"/>");
    }
    *out += "</linearGradient>\n";
    let fill = if low == high { ramp.at(0.5).to_string() } else { "url(#colours)".to_owned() };
    let [x, top, w, h, r] = [x0, y - cap, bar, cap, 0.2 * cap].map(|v| text_of(v, PX));
    *out +=
        &format!("<rect x=\"{x}\" y=\"{top}\" width=\"{w}\" height=\"{h}\" rx=\"{r}\" fill=\"{fill}\"/>\n");
    if let [Some(number), _] = &numbers {
        lettered(
            out,
            "low",
            number,
            Place { x: x0 - space, y, ..small(page.unit, Anchor::End) },
            palette.ink,
        );
    }
    if let [_, Some(number)] = &numbers {
        let place = Place { x: x1 + space, y, ..small(page.unit, Anchor::Start) };
        lettered(out, "high", number, place, palette.ink);
    }
    // A title longer than the bar is centred on it while there is room, then it shrinks.
    let length = lettering::width(title, cap);
    let room = page.width - 2.0 * MARGIN * page.unit;
    let shrink = (room / length.max(1e-9)).min(1.0);
    let x = (0.5 * (x0 + x1)).min(right - 0.5 * length * shrink);
    let place = Place { x, y: y - 1.9 * cap, ..small(page.unit, Anchor::Middle) };
    lettered(out, "label", title, Place { cap_height: cap * shrink, ..place }, palette.ink);
    *out += "</g>\n";
}

/// The one text size beside the scene.
pub(crate) fn small(unit: f64, anchor: Anchor) -> Place {
    Place { x: 0.0, y: 0.0, cap_height: CAP_HEIGHT * unit, anchor, up: Up::Negative, decimals: PX }
}

/// Draws text beside the scene, with a label for readers that cannot see strokes.
pub(crate) fn lettered(out: &mut String, class: &str, text: &str, place: Place, colour: Colour) {
    let mut d = String::new();
    lettering::strokes(&mut d, text, place);
    *out += &format!(
        "<path class=\"{class}\" aria-label=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\" \
         stroke-linecap=\"round\" stroke-linejoin=\"round\" d=\"{d}\"/>\n",
        escaped(text),
        text_of(PEN * place.cap_height, PX)
    );
}
