//! Draws everything that is to scale, in metres.

use crate::body::{DrawnBody, begin_at, near, point, polyline};
use crate::colour::{Colour, Palette};
use crate::colouring::Colouring;
use crate::density::density;
use crate::frame::Frame;
use crate::glyphs::{self, PEN, START, TextPlace};
use crate::page::{CASING, MARGIN, Page, dashes, path};
use crate::scene::{DrawnForce, MarkKind, PictureScene, PlaceMark, Trail};
use crate::style::Style;
use crate::text::{PX, escaped, text_of};
use lemons_core::plane::{Pose, Vec2, rotation, vec2};
use lemons_core::trial::{Geometry, Wall};

/// \[px\] Width of walls.
const WALL_STROKE: f64 = 2.4;
/// \[px\] Width of contour lines.
const GROUND_STROKE: f64 = 1.0;
/// \[px\] Width of a panel with a load.
const PANEL_STROKE: f64 = 9.0;
/// \[px\] Dashes of a wall that is open, and the gaps between their round ends.
const OPEN_DASHES: [f64; 2] = [2.0, 8.0];
/// \[px\] Largest width of the outline of a body.
const BODY_STROKE: f64 = 1.1;
/// Width of the outline of a body / square root of its area.
const BODY_STROKE_PART: f64 = 0.05;

/// Largest height of an Id / half depth of a body.
const TALLEST_ID: f64 = 0.56;
/// Ids with less room than this fraction of the median are left out, so that one small body does not make all Ids
/// small.
const LEAST_ID: f64 = 0.5;
/// \[px\] Objects that are cut extend this far beyond the view.
pub(crate) const CUT_BORDER: f64 = 0.4 * MARGIN;

/// \[px\] Halo on each side of a line of force; at most the width of the line.
pub(crate) const FORCE_HALO: f64 = 0.8;
/// \[px\] Width of a trail.
pub(crate) const TRAIL_STROKE: f64 = 1.5;
/// \[px\] Halo on each side of a trail.
const TRAIL_HALO: f64 = 0.9;
/// \[px\] Points of a trail nearer than this to the previous one are left out.
const TRAIL_STEP: f64 = 0.4;
/// Two feet in their own frame \[m\]: ellipses, 26 cm long and 9 cm wide.
const FEET: &str = "M.13 .08A.13 .045 0 01-.13 .08A.13 .045 0 01.13 .08ZM.13 -.08A.13 .045 0 01-.13 -.08A.13 .045 0 01.13 -.08Z";
/// \[m\] Distance from the middle of the feet to the furthest point.
const FEET_REACH: f64 = 0.16;
/// \[px\] Width of the line of the lean; the outline of feet has half of it.
const LEAN_STROKE: f64 = 1.3;
/// \[m\] The largest one.
const WIDEST_LEAN: f64 = 0.03;
/// \[m\] No line is drawn for a smaller lean.
const LEAST_LEAN: f64 = 0.01;
/// Number of shades of a trail.
const AGES: usize = 8;

/// \[px\] Width of the rim of a mark.
pub(crate) const MARK_STROKE: f64 = 2.0;

impl MarkKind {
    pub(crate) fn class(self) -> &'static str {
        match self {
            MarkKind::Exit => "exit",
            MarkKind::Distribution => "distribution",
            MarkKind::Waypoint => "way-point",
        }
    }

    pub(crate) fn colour(self, palette: &Palette) -> Colour {
        palette.series(self as usize)
    }
}

/// Returns whether the view cuts anything. Clipping makes rasterizing slow.
pub(crate) fn is_cut(scene: &PictureScene, frame: &Frame) -> bool {
    let bodies = scene.drawn().map(|(_, pose, body)| (pose.position, body.reach));
    let walls = scene.trial.geometry.walls.iter().flat_map(|wall| &wall.corners);
    let lines = walls.chain(scene.trails.iter().flat_map(|trail| &trail.points)).copied();
    let lines = lines.chain(scene.drawn_feet().map(|(_, feet)| feet));
    let points = lines.chain(drawable_forces(scene).flat_map(|f| [f.from, f.to])).filter(|p| near(*p));
    let seen = bodies.filter(|(p, reach)| frame.shows(*p, *reach));
    seen.chain(points.map(|p| (p, 0.0))).any(|(p, reach)| frame.cuts(p, reach))
}

/// Draws the scene into the frame, with lines of force of a width \[px/N\]; `cut`: without what is beyond the frame.
pub(crate) fn world(
    page: &mut Page,
    (scene, style): (&PictureScene, &Style),
    frame: &Frame,
    mut colouring: Colouring,
    force_scale: f64,
    cut: bool,
) {
    let Page { out, palette, .. } = page;
    // Trails that are compared with measured ones must be seen completely.
    let compared = measured(&[scene]);
    if colouring.scale.is_none() && compared {
        // Bodies of one colour become paler, so that the colours of the trails stand out.
        colouring.single = colouring.single.mixed(palette.paper, 0.6);
    }
    let (mut left, mut top) = (frame.left, frame.top);
    if cut {
        let border = CUT_BORDER * frame.unit;
        let [x, y, w, h] =
            [left - border, top - border, frame.drawn.x + 2.0 * border, frame.drawn.y + 2.0 * border]
                .map(|v| text_of(v, PX));
        *out += &format!("<svg x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\">\n");
        (left, top) = (border, border);
    }
    let (scale, px) = (frame.scale, frame.unit / frame.scale);
    let (x, y) = (left - scale * frame.view.low.x, top + scale * frame.view.high.y);
    let [s, x, y] = [scale, x, y].map(|v| text_of(v, 6));
    *out += &format!(
        "<g transform=\"matrix({s} 0 0 -{s} {x} {y})\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n"
    );
    if let (Some(map), Some(scale)) = (&scene.density, &colouring.scale) {
        density(out, map, frame, scale);
    }
    let mut world = World { out: &mut *out, palette, scene, style, frame, colouring: &colouring, px };
    world.grounds();
    world.walls();
    world.loads();
    world.marks();
    if !compared {
        world.aging_trails();
    }
    world.bodies();
    world.feet();
    if compared {
        world.compared_trails();
    }
    world.forces(force_scale / scale);
    if style.ids {
        world.ids();
    }
    *out += "</g>\n";
    if cut {
        *out += "</svg>\n";
    }
}

/// Returns the mean of values; 0 without any.
pub(crate) fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().sum::<f64>() / values.count().max(1) as f64
}

/// A scene that is being drawn in metres.
struct World<'a> {
    out: &'a mut String,
    palette: &'a Palette,
    scene: &'a PictureScene<'a>,
    style: &'a Style,
    frame: &'a Frame,
    colouring: &'a Colouring,
    /// \[m\] of one pixel.
    px: f64,
}

impl<'a> World<'a> {
    /// Draws a group with these attributes.
    fn group(&mut self, attributes: &str, inside: impl FnOnce(&mut Self)) {
        *self.out += &format!("<g {attributes}>\n");
        inside(self);
        *self.out += "</g>\n";
    }

    /// Returns the bodies on the page, with the indices of their agents.
    fn seen(&self) -> impl Iterator<Item = (usize, &'a Pose, &'a DrawnBody)> + Clone + use<'a> {
        let World { scene, frame, .. } = *self;
        scene.drawn().filter(move |(_, pose, body)| frame.shows(pose.position, body.reach))
    }

    /// \[m\] Returns the width of the outlines of bodies with these areas \[m²\].
    fn outline(&self, areas: impl Iterator<Item = f64> + Clone) -> String {
        text_of((BODY_STROKE * self.px).min(BODY_STROKE_PART * mean(areas).max(0.0).sqrt()), 6)
    }

    /// Draws the contour lines of slopes and stairs, each with an arrow downhill, and links as dashed lines.
    fn grounds(&mut self) {
        let Geometry { grounds, links, .. } = &self.scene.trial.geometry;
        if grounds.is_empty() && links.is_empty() {
            return;
        }
        let width = text_of(GROUND_STROKE * self.px, 6);
        let dashes = OPEN_DASHES.map(|length| text_of(length * self.px, 6)).join(" ");
        let colour = self.palette.ink;
        let look = format!(
            "class=\"grounds\" fill=\"none\" stroke=\"{colour}\" stroke-opacity=\".35\" stroke-width=\"{width}\""
        );
        self.group(&look, |world| {
            let draw = |out: &mut String, more: &str, lines: &[Vec<Vec2>], title: String| {
                let mut d = String::new();
                let drawable = lines.iter().filter(|line| line.iter().all(|end| near(*end)));
                drawable.for_each(|line| polyline(&mut d, line));
                *out += &format!("<path{more} d=\"{d}\"><title>{}</title></path>\n", escaped(&title));
            };
            for ground in grounds {
                let what = if ground.is_stairs() { "stairs" } else { "slope" };
                draw(world.out, "", &ground.lines(), format!("{what} {}", ground.id));
            }
            let more = format!(" stroke-dasharray=\"{dashes}\"");
            for link in links {
                let lines = link.lines.map(|line| line.to_vec());
                draw(world.out, &more, &lines, format!("link {}", link.id));
            }
        });
    }

    fn walls(&mut self) {
        let over_paper = [("walls", self.palette.wall, WALL_STROKE)];
        // White on the dark end of the map; dark around it on the bright end and on paper.
        let over_density =
            [("halo", Colour::hex(0x1c2b40), 1.6 * WALL_STROKE), ("walls", Colour::WHITE, 0.7 * WALL_STROKE)];
        let groups = if self.scene.density.is_some() { &over_density[..] } else { &over_paper };
        for (class, colour, width) in groups {
            let width = text_of(width * self.px, 6);
            let look =
                format!("class=\"{class}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"");
            self.group(&look, |world| {
                let height = world.scene.height;
                let there = |wall: &&Wall| height.is_none_or(|height| wall.heights.hold(height));
                for wall in world.scene.trial.geometry.walls.iter().filter(there) {
                    let corners: Vec<Vec2> = wall.corners.iter().copied().filter(|c| near(*c)).collect();
                    let [first, rest @ .., last] = &corners[..] else { continue };
                    let closed = first == last && rest.len() > 1;
                    if wall.is_open(world.style.time.unwrap_or(0.0)) {
                        let [dash, gap] = OPEN_DASHES.map(|length| text_of(length * world.px, 6));
                        *world.out += &format!("<path stroke-dasharray=\"{dash} {gap}\" d=\"");
                    } else {
                        *world.out += "<path d=\"";
                    }
                    polyline(world.out, &corners[..corners.len() - usize::from(closed)]);
                    *world.out += if closed { "Z\"/>\n" } else { "\"/>\n" };
                }
            });
        }
    }

    /// Draws the panels of a map of loads, each with a title.
    fn loads(&mut self) {
        let (Some(map), Some(scale)) = (&self.scene.loads, &self.colouring.scale) else { return };
        let width = text_of(PANEL_STROKE * self.px, 6);
        self.group(
            &format!("class=\"loads\" fill=\"none\" stroke-width=\"{width}\" stroke-linecap=\"butt\""),
            |world| {
                // What nobody touches stays a wall.
                let pressed = map.panels.iter().zip(&map.values.values).filter(|(_, value)| **value > 0.0);
                for (ends, value) in pressed.filter(|(ends, _)| ends.iter().all(|end| near(*end))) {
                    *world.out += &format!("<path stroke=\"{}\" d=\"", scale.of(*value));
                    polyline(world.out, ends);
                    *world.out += &format!("\"><title>{value:.3}</title></path>\n");
                }
            },
        );
    }

    fn marks(&mut self) {
        if self.scene.marks.is_empty() {
            return;
        }
        let width = text_of(MARK_STROKE * self.px, 6);
        let look = format!("class=\"marks\" stroke-width=\"{width}\" fill-opacity=\".18\"");
        self.group(&look, |world| {
            for PlaceMark { kind, name, corners } in &world.scene.marks {
                let corners: Vec<Vec2> = corners.iter().copied().filter(|corner| near(*corner)).collect();
                let is_area = corners.len() > 2;
                let (class, colour) = (kind.class(), kind.colour(world.palette));
                let fill = if is_area { colour.to_string() } else { "none".to_owned() };
                *world.out += &format!("<path class=\"{class}\" fill=\"{fill}\" stroke=\"{colour}\" d=\"");
                match corners[..] {
                    [] => (),
                    [at] => polyline(world.out, &[at, at]),
                    _ => polyline(world.out, &corners),
                }
                let end = if is_area { "Z" } else { "" };
                *world.out += &format!("{end}\"><title>{}</title></path>\n", escaped(name));
            }
        });
    }

    fn bodies(&mut self) {
        let seen = self.seen();
        let stroke = self.outline(seen.clone().map(|(_, _, body)| body.area));
        let outlined = self.scene.density.is_some();
        let Colouring { single, .. } = *self.colouring;
        let look = if outlined {
            "fill=\"none\" stroke=\"#ffffff\" stroke-opacity=\".75\"".to_owned()
        } else {
            format!("fill=\"{single}\" stroke=\"{}\"", self.palette.outline)
        };
        self.group(&format!("class=\"bodies\" {look} stroke-width=\"{stroke}\""), |world| {
            for (agent, pose, body) in seen {
                let id = world.scene.trial.agents.get(agent).map_or("", |a| &a.id);
                let fill = world.colouring.of(agent);
                begin_at(world.out, pose);
                if fill != single && !outlined {
                    *world.out += &format!(" fill=\"{fill}\"");
                }
                *world.out += &format!("><title>{}</title><path d=\"{}\"/>", escaped(id), body.outline);
                if world.style.orientation && !outlined {
                    mark(world.out, body, fill);
                }
                *world.out += "</g>\n";
            }
        });
    }

    /// Draws feet, as if they were seen through the bodies, and lines from there to the centres of mass.
    fn feet(&mut self) {
        let shown = self.scene.drawn_feet().filter(|(_, feet)| self.frame.shows(*feet, FEET_REACH));
        let shown: Vec<(&Pose, Vec2)> = shown.collect();
        if shown.is_empty() {
            return;
        }
        let width = (LEAN_STROKE * self.px).min(WIDEST_LEAN);
        let [rim, line, halo, dot] = [0.5, 1.0, 2.2, 2.6].map(|part| text_of(part * width, 6));
        let look = format!("fill-opacity=\".2\" stroke-opacity=\".6\" stroke-width=\"{rim}\"");
        let [paper, ink] = [self.palette.paper, self.palette.ink];
        self.group(&format!("class=\"feet\" fill=\"{paper}\" stroke=\"{ink}\" {look}"), |world| {
            for &(Pose { orientation, .. }, position) in &shown {
                begin_at(world.out, &Pose { position, orientation: *orientation });
                *world.out += &format!("><path d=\"{FEET}\"/></g>\n");
            }
        });
        let (mut leans, mut centres) = (String::new(), String::new());
        for (Pose { position, .. }, feet) in shown {
            if (*position - feet).norm() > LEAST_LEAN {
                polyline(&mut leans, &[feet, *position]);
                polyline(&mut centres, &[*position, *position]);
            }
        }
        self.group("class=\"leans\" fill=\"none\"", |World { out, .. }| {
            path(out, "halo", paper, &halo, " stroke-opacity=\".7\"", &leans);
            path(out, "lean", ink, &line, "", &leans);
            path(out, "centre", ink, &dot, "", &centres);
        });
    }

    /// Draws the Ids upright in the middle of the bodies, with a halo where lines cross them.
    fn ids(&mut self) {
        let crossed = !self.scene.trails.is_empty() || !self.scene.forces.is_empty();
        // In units of the letters' grid: integers and halves are short and exact.
        let (grid, height) = (glyphs::CAP, id_height(self.scene));
        let [pen, around] = [PEN * grid, 4.0 * PEN * grid].map(|width| text_of(width, PX));
        let around = format!(" stroke-width=\"{around}\"");
        self.group(&format!("class=\"ids\" fill=\"none\" stroke-width=\"{pen}\""), |world| {
            for (agent, pose, body) in world.seen() {
                let id = world.scene.trial.agents.get(agent).map(|a| a.id.as_str());
                let Some(id) = id.filter(|id| room(id, body) >= height) else { continue };
                let turn = rotation(pose.orientation);
                let middle = pose.position + turn * (body.middle - vec2(0.18 * body.front, 0.0));
                let (x, y) = (-(0.5 * glyphs::width(id, grid)).round(), -0.5 * grid);
                let (anchor, up, decimals) = (START, 1.0, 1);
                let mut d = String::new();
                glyphs::strokes(&mut d, id, TextPlace { x, y, cap_height: grid, anchor, up, decimals });
                let fill = world.colouring.of(agent);
                let halo = crossed.then_some((fill, around.as_str()));
                for (colour, more) in halo.into_iter().chain([(fill.contrast(), "")]) {
                    *world.out += "<path transform=\"translate(";
                    point(world.out, middle);
                    let scale = text_of(height / grid, 6);
                    *world.out += &format!(")scale({scale})\" stroke=\"{colour}\"{more} d=\"{d}\"/>\n");
                }
            }
        });
    }

    /// Draws simulated trails in one colour that becomes paler with age. The body at the end of a trail shows whose it is.
    fn aging_trails(&mut self) {
        if self.scene.trails.is_empty() {
            return;
        }
        let [core, cased, _] = self.trail_widths();
        self.group("class=\"trails\" fill=\"none\" stroke-linecap=\"butt\"", |world| {
            for age in 0..AGES {
                // Pieces of the same age are one path.
                let mut d = String::new();
                for Trail { points, .. } in &world.scene.trails {
                    let n = points.len();
                    let (from, to) = (age * n / AGES, ((age + 1) * n / AGES + 1).min(n));
                    world.trail(&mut d, &points[from.min(to)..to]);
                }
                let opacity = 0.15 + 0.8 * (age + 1) as f64 / AGES as f64;
                let [halo, line] =
                    [0.6 * opacity, opacity].map(|v| format!(" stroke-opacity=\"{}\"", text_of(v, 3)));
                path(world.out, "halo", world.palette.paper, &cased, &halo, &d);
                path(world.out, "simulated", world.palette.ink, &core, &line, &d);
            }
        });
    }

    /// Draws trails in the colours of their agents, the measured ones dashed.
    fn compared_trails(&mut self) {
        let [core, cased, casing] = self.trail_widths();
        let mut lines: Vec<(&Trail, String)> = Vec::new();
        for trail in &self.scene.trails {
            let mut d = String::new();
            self.trail(&mut d, &trail.points);
            lines.push((trail, d));
        }
        // Draw dashed lines last, so that solid lines do not hide them.
        lines.sort_by_key(|(trail, _)| trail.measured);
        let all: String = lines.iter().map(|(_, d)| d.as_str()).collect();
        self.group("class=\"trails\" fill=\"none\"", |World { out, palette, px, .. }| {
            let [around, dashed] = dashes(*px);
            path(out, "halo", palette.paper, &cased, " stroke-opacity=\".85\"", &all);
            for (trail, d) in &lines {
                let colour = palette.series(trail.agent);
                if trail.measured {
                    path(out, "casing", palette.paper, &casing, &around, d);
                    path(out, "measured", colour, &core, &dashed, d);
                } else {
                    path(out, "simulated", colour, &core, "", d);
                }
            }
        });
    }

    /// \[m\] Returns the widths of a trail, of its halo, and of the border of its dashes.
    fn trail_widths(&self) -> [String; 3] {
        [0.0, TRAIL_HALO, CASING].map(|around| text_of((TRAIL_STROKE + 2.0 * around) * self.px, 6))
    }

    /// Writes a trail, split at points that cannot be drawn, without points too close to be seen.
    fn trail(&self, d: &mut String, points: &[Vec2]) {
        let far = |a: Vec2, b: Vec2| (b - a).norm() >= TRAIL_STEP * self.px;
        for piece in points.split(|p| !near(*p)) {
            let mut kept: Vec<Vec2> = Vec::new();
            for (k, p) in piece.iter().enumerate() {
                if k + 1 == piece.len() || kept.last().is_none_or(|last| far(*last, *p)) {
                    kept.push(*p);
                }
            }
            // A person who stood still has no trail: a dot would be only halo.
            if kept.len() > 2 || matches!(kept[..], [a, b] if far(a, b)) {
                polyline(d, &kept);
            }
        }
    }

    /// Draws lines of force of a width \[m/N\]: all halos below all lines, so that a chain of forces looks connected.
    fn forces(&mut self, width: f64) {
        if self.scene.forces.is_empty() {
            return;
        }
        // Weak forces first, so that they do not cross strong ones.
        let mut drawn: Vec<(f64, &DrawnForce)> =
            drawable_forces(self.scene).map(|f| (f.normal_force * width, f)).collect();
        drawn.retain(|(width, _)| *width > 0.01 * self.px);
        drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
        let groups = [("force-halos", Colour::WHITE, FORCE_HALO * self.px), ("forces", Colour::FORCE, 0.0)];
        for (class, colour, halo) in groups {
            self.group(&format!("class=\"{class}\" fill=\"none\" stroke=\"{colour}\""), |world| {
                for (width, force) in &drawn {
                    let width = text_of(width + 2.0 * halo.min(*width), 6);
                    *world.out += &format!("<path stroke-width=\"{width}\" d=\"");
                    polyline(world.out, &[force.from, force.to]);
                    *world.out += "\"/>\n";
                }
            });
        }
    }
}

/// Draws a small arrow head inside the front.
fn mark(out: &mut String, body: &DrawnBody, fill: Colour) {
    let at = |ahead: f64, aside: f64| body.middle + vec2(ahead, aside) * body.front;
    let colour = fill.mixed(fill.contrast(), 0.7);
    *out += &format!("<path fill=\"{colour}\" stroke=\"none\" d=\"");
    polyline(out, &[at(0.88, 0.0), at(0.58, 0.23), at(0.58, -0.23)]);
    *out += "Z\"/>";
}

/// \[m\] Returns the cap height of an Id for which a body has room.
fn room(id: &str, body: &DrawnBody) -> f64 {
    (body.front / glyphs::width(id, 1.0).max(0.1)).min(TALLEST_ID * body.front)
}

fn rooms<'a>(scene: &'a PictureScene) -> impl Iterator<Item = (&'a str, f64)> {
    let named = scene.trial.agents.iter().map(|agent| agent.id.as_str());
    named.zip(&scene.bodies).filter(|(_, body)| !body.disks.is_empty()).map(|(id, body)| (id, room(id, body)))
}

/// \[m\] Returns the cap height of all Ids: the smallest for which there is room, without those left out. It depends on
/// the Trial only, so that it is the same in all frames of a movie.
fn id_height(scene: &PictureScene) -> f64 {
    let mut all: Vec<f64> = rooms(scene).map(|(_, room)| room).collect();
    all.sort_by(f64::total_cmp);
    let Some(middle) = all.get(all.len().saturating_sub(1) / 2) else { return 0.0 };
    all.iter().copied().find(|room| *room >= LEAST_ID * middle).unwrap_or(*middle)
}

/// Returns the Ids that pictures leave out because they would be much smaller than the others.
pub fn ids_without_room<'a>(scene: &'a PictureScene) -> Vec<&'a str> {
    let height = id_height(scene);
    rooms(scene).filter(|(_, room)| *room < height).map(|(id, _)| id).collect()
}

/// Returns whether trails are compared with measured ones.
pub(crate) fn measured(scenes: &[&PictureScene]) -> bool {
    scenes.iter().flat_map(|s| &s.trails).any(|t| t.measured)
}

/// Returns the forces that can be drawn.
pub(crate) fn drawable_forces<'a>(scene: &'a PictureScene) -> impl Iterator<Item = &'a DrawnForce> {
    let drawable =
        |f: &&DrawnForce| near(f.from) && near(f.to) && f.normal_force.is_finite() && f.normal_force > 0.0;
    scene.forces.iter().filter(drawable)
}
