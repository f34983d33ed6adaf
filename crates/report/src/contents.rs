//! What a report contains.

use crate::seen::{Moment, RunSeen, SAMPLE};
use crate::sentences::*;
use crate::{Block, Report, Section};
use lemons_core::message::{Message, Sentence, message};
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::Trial;
use lemons_decision::Plan;
use lemons_decision::rule::UNLIMITED;
use lemons_decision::spread::Spread;
use lemons_decision::target::Target;
use lemons_picture::{
    Chart, ChartPanel, ChartStyle, ColourMap, Curve, Fill, LoadMap, PictureScene, Style, Values, chart_svg, svg,
};
use lemons_results::measure::{
    Across, Flow, MeanInterval, Over, Panel, Passage, SPANS, WallLoad, WallLoads,
};
use std::collections::BTreeMap;

/// Panels that are listed.
const MOST_PANELS: usize = 10;
/// People who are named where some have not left.
const MOST_NAMES: usize = 8;
/// \[px\] Width of pictures.
const WIDTH: f64 = 720.0;

/// What is told of the runs besides.
#[derive(Debug, Clone, Default)]
pub struct Told {
    /// Name of the scenario.
    pub title: String,
    /// Where it is from, such as a path.
    pub source: String,
    /// Date of its file; empty: not known.
    pub changed: String,
    /// By which the same documents are known again; empty: not known.
    pub digest: String,
    /// The program with its version.
    pub program: String,
    /// Keys and values that are not the usual ones.
    pub settings: Vec<(String, String)>,
    /// Seeds whose runs have no result, and why.
    pub failed: Vec<(u64, String)>,
    /// What is probably not meant, and what was chosen.
    pub warnings: Vec<Message>,
}

impl Report {
    /// Makes the report of runs, of which there is at least one.
    pub fn of(told: &Told, runs: &[RunSeen]) -> Report {
        let Some(first) = runs.first() else {
            let notices = told.failed.iter().map(|(seed, why)| message!(FAILED, seed = *seed as usize, why));
            return Report { title: told.title.clone(), notices: notices.collect(), sections: Vec::new() };
        };
        let many = Many { runs, told };
        let sections = [
            (RESULTS, many.results()),
            (PLAN, vec![many.plan(first)]),
            (PEOPLE, vec![people(&first.trial, many.seed_of(first))]),
            (ASSUMED, many.assumed(first)),
            (LEAVING, many.leaving(first)),
            (CROWDING, many.density()),
            (PRESSING, many.squeeze()),
            (WALLS, many.loads()),
            (EACH, if runs.len() > 1 { vec![many.each()] } else { Vec::new() }),
            (WARNINGS, vec![many.warnings()]),
            (LIMITS, vec![many.limits()]),
            (VERSIONS, vec![many.versions()]),
        ];
        let sections = sections.into_iter().filter(|(_, blocks)| !blocks.is_empty());
        let section = |(heading, blocks)| Section { heading: Message::new(heading, &[]), blocks };
        Report { title: told.title.clone(), notices: many.notices(), sections: sections.map(section).collect() }
    }
}

/// A number of a run, and where it is from.
type Found = Option<(f64, Message)>;

fn number(value: f64, decimals: usize) -> Message {
    format!("{value:.decimals$}").into()
}

fn plain(sentence: Sentence) -> Message {
    Message::new(sentence, &[])
}

fn heads<const N: usize>(all: [Sentence; N]) -> Vec<Message> {
    all.map(plain).to_vec()
}

fn at(time: f64) -> Message {
    message!(AT, time)
}

/// Runs of one scenario.
struct Many<'a> {
    runs: &'a [RunSeen],
    told: &'a Told,
}

impl Many<'_> {
    fn one(&self) -> bool {
        self.runs.len() == 1
    }

    /// Returns a seed in words where there are several.
    fn seed_of(&self, run: &RunSeen) -> Message {
        let seed = run.seed.filter(|_| !self.one());
        seed.map_or(Message::default(), |seed| message!(OF_SEED, seed = seed as usize))
    }

    /// Returns the number of runs in words.
    fn count(&self) -> Message {
        if self.one() { plain(SINGLE) } else { message!(SEVERAL, runs = self.runs.len()) }
    }

    /// Returns the row of a quantity: of one run its value, else mean, interval, least and greatest.
    fn row(&self, label: Message, unit: &str, decimals: usize, of: impl Fn(&RunSeen) -> Found) -> Vec<Message> {
        let found: Vec<(&RunSeen, f64, Message)> =
            self.runs.iter().filter_map(|run| of(run).map(|(value, at)| (run, value, at))).collect();
        let dash = || Message::from("–");
        let order = |a: &&(&RunSeen, f64, Message), b: &&(&RunSeen, f64, Message)| a.1.total_cmp(&b.1);
        let (least, most) = (found.iter().min_by(order), found.iter().max_by(order));
        let most = most.map_or((dash(), Message::default()), |(run, value, at)| {
            let seed = run.seed.filter(|_| !self.one());
            let value = number(*value, decimals);
            (value.clone(), seed.map_or(at.clone(), |seed| message!(IN_SEED, value = at, seed = seed as usize)))
        });
        if self.one() {
            return vec![label, most.0, unit.into(), most.1];
        }
        let values: Vec<f64> = found.iter().map(|(_, value, _)| *value).collect();
        let mean = MeanInterval::of(&values);
        let ends = mean.and_then(|mean| mean.ends());
        let ends = ends.map_or_else(dash, |[low, high]| {
            format!("{low:.decimals$} – {high:.decimals$}").into()
        });
        let mean = mean.map_or_else(dash, |mean| number(mean.mean, decimals));
        let least = least.map_or_else(dash, |(_, value, _)| number(*value, decimals));
        vec![label, unit.into(), mean, ends, least, most.0, most.1, values.len().to_string().into()]
    }

    /// Makes a table of such rows.
    fn table(&self, caption: Option<Message>, rows: Vec<Vec<Message>>) -> Block {
        let (head, usual) = if self.one() {
            (heads([QUANTITY, VALUE, UNIT, WHERE]), plain(OF_ONE))
        } else {
            let usual = message!(OF_RUNS, runs = self.runs.len());
            (heads([QUANTITY, UNIT, MEAN, INTERVAL, LEAST, GREATEST, WHERE, RUNS]), usual)
        };
        Block::table(caption.unwrap_or(usual), head, rows)
    }

    fn notices(&self) -> Vec<Message> {
        let failed = self.told.failed.iter();
        let mut all: Vec<Message> =
            failed.map(|(seed, why)| message!(FAILED, seed = *seed as usize, why)).collect();
        for run in self.runs {
            let Some(why) = &run.why_some_stay else { continue };
            let mut who = run.stay.iter().take(MOST_NAMES).cloned().collect::<Vec<_>>().join(", ");
            if run.stay.len() > MOST_NAMES {
                who += ", …";
            }
            all.push(match run.seed.filter(|_| !self.one()) {
                Some(seed) => message!(STAYED, seed = seed as usize, why, who),
                None => message!(STAYED_ONE, why, who),
            });
        }
        let left = self.runs.iter().all(|run| run.over == Some(Over::Left));
        if all.is_empty() && left {
            all.push(if self.one() { plain(ALL_OUT_ONE) } else { message!(ALL_OUT, runs = self.runs.len()) });
        }
        all.extend(self.one().then(|| plain(ONE_RUN)));
        all
    }

    fn results(&self) -> Vec<Block> {
        let first = &self.runs[0];
        let (limit, over) = first.settings.limit;
        let mut rows = Vec::new();
        if first.counts.0 > 0 {
            let none = Message::default;
            rows.push(self.row(plain(EVACUATION), "s", 1, |run| {
                (run.over == Some(Over::Left)).then(|| (run.end, none()))
            }));
            rows.push(self.row(plain(LEFT), "", 0, |run| Some((run.counts.1 as f64, none()))));
            rows.push(self.row(plain(STAY), "", 0, |run| Some((run.stay.len() as f64, none()))));
            rows.push(self.row(message!(WAIT), "s", 1, |run| {
                let wait = run.wait?;
                Some((wait.time, message!(OF_AT, who = &run.trial.agents[wait.agent].id, time = wait.from)))
            }));
        }
        rows.push(self.row(plain(DENSEST), "1/m²", 1, |run| run.dense.as_ref().map(|of| (of.value, at(of.time)))));
        let by = |run: &RunSeen, moment: &Moment| {
            message!(OF_AT, who = &run.trial.agents[moment.who].id, time = moment.time)
        };
        if !SPANS.contains(&over) {
            let own = |run: &RunSeen| run.pressed.as_ref().map(|moment| (moment.value, by(run, moment)));
            rows.push(self.row(message!(SQUEEZE, over), "N", 0, own));
        }
        for (k, over) in SPANS.into_iter().enumerate().rev() {
            let label = if k == 0 { plain(SQUEEZE_01) } else { message!(SQUEEZE, over) };
            rows.push(self.row(label, "N", 0, |run| {
                let known = run.exposure.iter().flatten().zip(&run.trial.agents);
                let most = known.filter_map(|(one, agent)| Some((one.largest_mean[k]?, one.largest_mean_at[k], &agent.id)));
                let (value, time, who) = most.max_by(|a, b| a.0.total_cmp(&b.0))?;
                Some((value, message!(OF_AT, who, time)))
            }));
        }
        rows.push(self.row(plain(SQUEEZE_90), "N", 0, |run| {
            let all: Option<Vec<f64>> = run.exposure.as_ref()?.iter().map(|one| one.largest_mean[1]).collect();
            Some((Across::Quantile90.of(all?.into_iter())?, Message::default()))
        }));
        let above = |run: &RunSeen| -> Option<Vec<_>> {
            run.exposure.as_ref()?.iter().map(|one| one.above[0]).collect()
        };
        rows.push(self.row(message!(ABOVE, limit, over), "", 0, |run| {
            let first = above(run)?.into_iter().filter_map(|one| one.first).collect::<Vec<_>>();
            let begin = first.iter().copied().reduce(f64::min);
            Some((first.len() as f64, begin.map_or(Message::default(), at)))
        }));
        rows.push(self.row(plain(ABOVE_TIME), "s", 1, |run| {
            Some((above(run)?.iter().map(|one| one.time).sum(), Message::default()))
        }));
        for (k, over) in [(1, 1.0), (10, 10.0)] {
            let of = |load: &WallLoad| if k == 1 { load.load_1.zip(load.load_1_at) } else { load.load_10.zip(load.load_10_at) };
            if self.runs.iter().any(|run| run.loads.is_some()) {
                rows.push(self.row(message!(LOAD, over), "kN/m", 2, |run| most_loaded(run, of)));
            }
        }
        if first.fallen.is_some() {
            rows.push(self.row(plain(FELL), "", 0, |run| Some((run.fallen? as f64, Message::default()))));
        }
        rows.push(self.row(plain(OVERLAP), "mm", 1, |run| Some((1e3 * run.overlap, Message::default()))));
        vec![self.table(None, rows)]
    }

    fn plan(&self, first: &RunSeen) -> Block {
        let caption = message!(THE_PLAN, seed = self.seed_of(first));
        drawn(caption, &first.scene(None), Style::default())
    }

    fn assumed(&self, first: &RunSeen) -> Vec<Block> {
        let RunSeen { trial, plan, settings, .. } = first;
        let mut rows: Vec<(Message, Message)> = Vec::new();
        let seeds = self.runs.iter().filter_map(|run| Some(run.seed?.to_string()));
        let seeds: Vec<String> = seeds.collect();
        if !seeds.is_empty() {
            rows.push((plain(SEEDS), seeds.join(", ").into()));
        }
        let until = match (settings.until.time(), plan) {
            (None, _) => message!(UNTIL_LEFT, time = settings.until.latest()),
            (Some(time), Some(plan)) if plan.leaving().contains(&true) => message!(UNTIL_LEFT, time),
            (Some(time), _) => message!(UNTIL_TIME, time),
        };
        rows.push((plain(UNTIL), until));
        of_plan(plan.as_ref(), &mut rows);
        of_trial(trial, &mut rows);
        let rows = rows.into_iter().map(|(name, value)| vec![name, value]).collect();
        let mut all = vec![Block::table(plain(ASSUMPTIONS), Vec::new(), rows)];
        if !self.told.settings.is_empty() {
            let row = |(key, value): &(String, String)| vec![key.as_str().into(), value.as_str().into()];
            let rows = self.told.settings.iter().map(row).collect();
            all.push(Block::table(plain(SETTINGS), Vec::new(), rows));
        }
        all
    }

    fn leaving(&self, first: &RunSeen) -> Vec<Block> {
        let targets = first.plan.iter().flat_map(|plan| &plan.targets).enumerate();
        let mut rows = Vec::new();
        for (k, Target { name, .. }) in targets.filter(|(_, target)| !target.stay) {
            let exit = &message!(EXIT, name);
            let of = |run: &RunSeen| -> Vec<Passage> {
                let own = run.departures.iter().filter(|(_, exit)| *exit == Some(k));
                own.map(|(time, _)| Passage { time: *time, agent: 0 }).collect()
            };
            let none = Message::default;
            rows.push(self.row(message!(BY_PEOPLE, exit), "", 0, |run| Some((of(run).len() as f64, none()))));
            rows.push(self.row(message!(BY_FLOW, exit), "1/s", 3, |run| Some((Flow::of(&of(run)).rate?, none()))));
            rows.push(self.row(message!(BY_FIRST, exit), "s", 1, |run| Some((of(run).first()?.time, none()))));
            rows.push(self.row(message!(BY_LAST, exit), "s", 1, |run| Some((of(run).last()?.time, none()))));
        }
        if rows.is_empty() || first.counts.0 == 0 {
            return Vec::new();
        }
        let curve = |(group, run): (usize, &RunSeen)| {
            let gone = run.departures.iter().enumerate().map(|(n, (time, _))| (*time, (n + 1) as f64));
            let last = run.departures.len() as f64;
            let name = run.seed.map_or(String::new(), |seed| seed.to_string());
            let points = [(0.0, 0.0)].into_iter().chain(gone).chain([(run.end, last)]).collect();
            Curve { name, points, group, dashed: false }
        };
        let lines = self.runs.iter().enumerate().map(curve).collect();
        let panel = ChartPanel { y: "people who have left".into(), lines, steps: true };
        let chart = Chart { x: "time (s)".into(), panels: vec![panel], noun: "seed".into() };
        let svg = chart_svg(&chart, &ChartStyle { width: WIDTH, aspect: Some(0.3), ..ChartStyle::default() });
        vec![self.table(Some(plain(EXITS)), rows), Block::Picture { caption: plain(CURVE), svg }]
    }

    fn density(&self) -> Vec<Block> {
        let found = self.runs.iter().filter_map(|run| Some((run, run.dense.as_ref()?)));
        let Some((run, Moment { time, value, poses, .. })) = found.max_by(|a, b| a.1.value.total_cmp(&b.1.value)) else {
            return Vec::new();
        };
        let mut map = lemons_picture::DensityMap::new(run.density.view(), lemons_picture::DENSITY_KERNEL, &run.trial.geometry.walls);
        map.add(poses.iter().map(|pose| pose.position));
        let (time, value, sample) = (*time, *value, SAMPLE);
        let seed = self.seed_of(run);
        let kernel = |map: &lemons_picture::DensityMap| capital(&map.described());
        let caption = message!(WORST_DENSITY, time, seed, sample, value, kernel = kernel(&map));
        let mut scene = run.scene(Some(poses.clone()));
        scene.density = Some(map);
        let worst = drawn(caption, &scene, Style { time: Some(time), ..Style::default() });
        let first = &self.runs[0];
        let mut mean = first.density.clone();
        // People without walls begin elsewhere with each seed: there is no common map.
        let same = self.runs.iter().skip(1).filter(|run| run.density.view() == first.density.view());
        let joined = same.map(|run| mean.join(&run.density)).count();
        let runs = if joined == 0 { plain(SINGLE) } else { message!(SEVERAL, runs = joined + 1) };
        let caption = message!(MEAN_DENSITY, runs, sample, kernel = kernel(&mean));
        let mut scene = first.scene(Some(Vec::new()));
        scene.density = Some(mean);
        vec![worst, drawn(caption, &scene, Style::default())]
    }

    fn squeeze(&self) -> Vec<Block> {
        let (_, over) = self.runs[0].settings.limit;
        let found = || self.runs.iter().filter_map(|run| Some((run, run.pressed.as_ref()?)));
        let Some((run, moment)) = found().max_by(|a, b| a.1.value.total_cmp(&b.1.value)) else {
            return vec![Block::Text { text: message!(NO_SQUEEZE, over) }];
        };
        let row = |(run, of): (&RunSeen, &Moment)| {
            let at = of.poses[of.who].position;
            let agent = &run.trial.agents[of.who];
            let walls = 100.0 * of.by_walls / of.value;
            let who = agent.kind.as_ref().map_or(agent.id.clone(), |kind| format!("{} ({kind})", agent.id));
            let seed = run.seed.map_or("–".to_owned(), |seed| seed.to_string());
            vec![
                seed.into(),
                who.into(),
                number(of.value, 0),
                number(100.0 - walls, 0),
                number(walls, 0),
                number(of.time, 2),
                number(at.x, 2),
                number(at.y, 2),
            ]
        };
        let head = heads([SEED, PERSON, NEWTONS, BY_OTHERS, BY_WALLS, TIME, PLACE_X, PLACE_Y]);
        let table = Block::table(message!(PRESSED, over), head, found().map(row).collect());
        let (time, value, seed) = (moment.time, moment.value, self.seed_of(run));
        let caption = message!(WORST_SQUEEZE, time, seed, over, value, who = &run.trial.agents[moment.who].id);
        let values = Values { map: ColourMap::FromGrey, ..Values::of(moment.values.clone(), "mean squeeze", "N") };
        let style = Style { fill: Fill::Values(values), time: Some(time), range: Some((0.0, value)), ..Style::default() };
        vec![table, drawn(caption, &run.scene(Some(moment.poses.clone())), style)]
    }

    fn loads(&self) -> Vec<Block> {
        let runs: Vec<(&RunSeen, &WallLoads)> =
            self.runs.iter().filter_map(|run| Some((run, run.loads.as_ref()?))).collect();
        let Some((first, loads)) = runs.first() else { return Vec::new() };
        // Of other walls in another run, there is no common panel.
        let same = |own: &&(&RunSeen, &WallLoads)| own.1.panels.iter().map(|of| &of.0).eq(loads.panels.iter().map(|of| &of.0));
        let of = |k: usize, load: fn(&WallLoad) -> Option<(f64, f64)>| -> Vec<(f64, f64, Option<u64>)> {
            let all = runs.iter().filter(same);
            all.filter_map(|(run, own)| load(&own.panels[k].1).map(|(load, at)| (load / 1e3, at, run.seed))).collect()
        };
        type Load = fn(&WallLoad) -> Option<(f64, f64)>;
        let kinds: [Load; 3] = [
            |load| load.load_1.zip(load.load_1_at),
            |load| load.load_10.zip(load.load_10_at),
            |load| load.load_peak.zip(load.load_peak_at),
        ];
        let most = |all: &[(f64, f64, Option<u64>)]| all.iter().copied().max_by(|a, b| a.0.total_cmp(&b.0));
        let greatest: Vec<f64> =
            (0..loads.panels.len()).map(|k| most(&of(k, kinds[0])).map_or(f64::NAN, |most| most.0)).collect();
        let mut order: Vec<usize> = (0..greatest.len()).filter(|k| greatest[*k] > 0.0).collect();
        order.sort_by(|a, b| greatest[*b].total_cmp(&greatest[*a]));
        if order.is_empty() {
            return vec![Block::Text { text: plain(NO_LOAD) }];
        }
        let cell = |all: &[(f64, f64, Option<u64>)]| {
            most(all).map_or("–".into(), |(load, time, seed)| {
                let value = format!("{load:.2}, {time:.1} s");
                match seed.filter(|_| !self.one()) {
                    Some(seed) => message!(IN_SEED, value, seed = seed as usize),
                    None => value.into(),
                }
            })
        };
        let row = |k: &usize| {
            let Panel { wall, .. } = &loads.panels[*k].0;
            let [from, to] = loads.panels[*k].0.ends();
            let middle = (from + to) * 0.5;
            let first = of(*k, kinds[0]);
            let mean = first.iter().map(|of| of.0).sum::<f64>() / first.len() as f64;
            let place = [number(middle.x, 2), number(middle.y, 2), number(loads.panels[*k].0.length(), 2), number(mean, 2)];
            let loads = [first, of(*k, kinds[1]), of(*k, kinds[2])].map(|all| cell(&all));
            [Message::from(wall.as_str())].into_iter().chain(place).chain(loads).collect()
        };
        let (count, all) = (order.len().min(MOST_PANELS), order.len());
        let head = heads([WALL, PLACE_X, PLACE_Y, LENGTH, LOAD_1_MEAN, LOAD_1, LOAD_10, LOAD_PEAK]);
        let table = Block::table(message!(LOADED, count, all), head, order.iter().take(count).map(row).collect());
        let mut scene = first.scene(Some(Vec::new()));
        let values = Values { map: ColourMap::FromPaper, ..Values::of(greatest, "greatest mean load over 1 s", "kN/m") };
        scene.loads = Some(LoadMap { panels: loads.panels.iter().map(|(panel, _)| panel.ends()).collect(), values });
        let picture = drawn(message!(LOAD_MAP, runs = self.count()), &scene, Style::default());
        let notes = vec![plain(DESIGN_LOADS), message!(NO_DESIGN, runs = self.count())];
        vec![table, Block::List { items: notes }, picture]
    }

    fn each(&self) -> Block {
        let row = |run: &RunSeen| {
            let why = match run.over {
                Some(Over::Left) => WHEN_LEFT,
                Some(Over::Standstill) => STANDSTILL,
                None if run.counts.0 > 0 => LATEST,
                None => TIMED,
            };
            let dash = |value: Option<f64>, decimals| value.map_or("–".into(), |value| number(value, decimals));
            let load = most_loaded(run, |load| load.load_1.zip(load.load_1_at)).map(|(load, _)| load);
            vec![
                run.seed.map_or("–".to_owned(), |seed| seed.to_string()).into(),
                number(run.end, 1),
                plain(why),
                number(run.counts.1 as f64, 0),
                number(run.stay.len() as f64, 0),
                dash(run.dense.as_ref().map(|of| of.value), 1),
                dash(run.pressed.as_ref().map(|of| of.value), 0),
                dash(load, 2),
            ]
        };
        let head = heads([SEED, ENDED, WHY, OUT, NOT_OUT, DENSITY_OF, NEWTONS, LOAD_OF]);
        Block::table(message!(RUN_TABLE, sample = SAMPLE), head, self.runs.iter().map(row).collect())
    }

    fn warnings(&self) -> Block {
        let mut items = self.told.warnings.clone();
        for run in self.runs {
            let seed = run.seed.filter(|_| !self.one());
            items.extend(run.findings.iter().map(|finding| match seed {
                Some(seed) => message!(IN_RUN, seed = seed as usize, finding),
                None => finding.clone(),
            }));
        }
        if items.is_empty() { Block::Text { text: plain(NO_WARNINGS) } } else { Block::List { items } }
    }

    fn limits(&self) -> Block {
        let limit = self.runs[0].settings.limit.0;
        let first = if self.one() { ONE_RUN } else { NOT_SAMPLE };
        let mut items: Vec<Message> = [first, NOT_SURVEY, NOT_PLANE, NOT_PROOF].map(plain).to_vec();
        items.push(message!(NOT_INJURY, limit));
        Block::List { items }
    }

    fn versions(&self) -> Block {
        let Told { source, changed, digest, program, .. } = self.told;
        let rows = [(PROGRAM, program), (DATA, source), (CHANGED, changed), (DIGEST, digest)].into_iter();
        let rows = rows.filter(|(_, value)| !value.is_empty()).map(|(name, value)| vec![plain(name), value.as_str().into()]);
        Block::table(plain(MADE), Vec::new(), rows.collect())
    }
}

fn capital(text: &str) -> String {
    let mut all = text.chars();
    all.next().map_or(String::new(), |first| first.to_uppercase().chain(all).collect())
}

/// Draws a scene.
fn drawn(caption: Message, scene: &PictureScene, style: Style) -> Block {
    Block::Picture { caption, svg: svg(scene, &Style { width: WIDTH, orientation: false, ..style }) }
}

/// Returns the greatest load on a panel \[kN/m\], where and when it was.
fn most_loaded(run: &RunSeen, of: impl Fn(&WallLoad) -> Option<(f64, f64)>) -> Found {
    let all = run.loads.iter().flat_map(|loads| &loads.panels);
    let known = all.filter_map(|(panel, load)| of(load).map(|(load, time)| (panel, load, time)));
    let (panel, load, time) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let [from, to] = panel.ends();
    let middle = (from + to) * 0.5;
    let place = message!(WALL_AT, wall = &panel.wall, x = middle.x, y = middle.y, time);
    Some((load / 1e3, if load > 0.0 { place } else { Message::default() }))
}

/// Least, greatest and mean.
fn spread(values: impl Iterator<Item = f64>) -> Option<[f64; 3]> {
    let values: Vec<f64> = values.collect();
    let of = |across: Across| across.of(values.iter().copied());
    Some([of(Across::Min)?, of(Across::Max)?, of(Across::Mean)?])
}

/// Says who the people are.
fn people(trial: &Trial, seed: Message) -> Block {
    let mut kinds: BTreeMap<Option<&str>, Vec<&lemons_core::trial::Agent>> = BTreeMap::new();
    trial.agents.iter().for_each(|agent| kinds.entry(agent.kind.as_deref()).or_default().push(agent));
    let row = |name: Message, agents: &[&lemons_core::trial::Agent]| {
        let [least, most, mean] = spread(agents.iter().map(|agent| agent.mass)).unwrap_or_default();
        let height = spread(agents.iter().filter_map(|agent| agent.height));
        let height = height.map_or("–".into(), |[.., mean]| number(mean, 2));
        let masses = format!("{least:.0} – {most:.0}");
        vec![name, agents.len().to_string().into(), number(mean, 1), masses.into(), height]
    };
    let all: Vec<_> = trial.agents.iter().collect();
    let named = |kind: &Option<&str>| kind.map_or(plain(NO_KIND), Message::from);
    let mut rows: Vec<_> = kinds.iter().map(|(kind, agents)| row(named(kind), agents)).collect();
    if rows.len() > 1 {
        rows.push(row(plain(ALL_PEOPLE), &all));
    }
    Block::table(message!(KINDS, seed), heads([KIND, NUMBER, MASS, MASSES, HEIGHT]), rows)
}

/// Says how people walk.
fn of_plan(plan: Option<&Plan>, rows: &mut Vec<(Message, Message)>) {
    let Some(plan) = plan else {
        rows.push((plain(MODEL), plain(NO_MODEL)));
        return;
    };
    let mut row = |name: Sentence, value: Message| rows.push((plain(name), value));
    row(MODEL, plan.walking_model.name().name().into());
    let walkers = || plan.agents.iter().map(|agent| &agent.walker);
    if let Some([least, most, mean]) = spread(walkers().map(|walker| walker.desired_speed)) {
        row(SPEED, message!(SPEEDS, least, most, mean));
    }
    if let Some([least, most, _]) = spread(walkers().map(|walker| walker.push)) {
        row(PUSH, if most >= UNLIMITED { plain(ANY_PUSH) } else { message!(PUSHES, least, most) });
    }
    let lean = plan.queue.as_ref().map(|(queue, _)| match queue.push {
        Spread::Same(push) => push.to_string(),
        Spread::Drawn(from) => format!("0 – {}", from.max()),
    });
    row(LEAN, lean.map_or(plain(NO), |push| message!(LEANS, push)));
    if let Some([least, most, _]) = spread(walkers().map(|walker| walker.start)) {
        row(STARTS, message!(START_TIMES, least, most));
    }
    row(GROUPS, plan.groups.len().to_string().into());
    row(CHOICE, format!("{:?}", plan.exit_choice).to_lowercase().into());
    for Target { name, corners, open, .. } in plan.targets.iter().filter(|target| !target.stay) {
        let place = match corners[..] {
            [[x1, y1], [x2, y2]] => message!(LINE, x1, y1, x2, y2),
            _ => {
                let sum = corners.iter().fold(vec2(0.0, 0.0), |sum, corner| sum + Vec2::from(*corner));
                let middle = sum * (1.0 / corners.len().max(1) as f64);
                message!(AREA, x = middle.x, y = middle.y)
            }
        };
        let times = open.iter().flat_map(|open| open.pairs());
        let place = times.fold(place, |place, [from, to]| message!(OPEN, place, from = *from, to = *to));
        rows.push((message!(EXIT, name), place));
    }
}

/// Says what bodies and walls are like.
fn of_trial(trial: &Trial, rows: &mut Vec<(Message, Message)>) {
    let mut row = |name: Sentence, value: Message| rows.push((plain(name), value));
    if let Some([least, most, _]) = spread(trial.agents.iter().map(|agent| agent.shapes.len() as f64)) {
        row(BODIES, message!(DISKS, least, most));
    }
    for of in &trial.materials.intrinsic {
        row(MATERIALS, message!(MATERIAL, id = &of.id, young = of.young_modulus, shear = of.shear_modulus));
    }
    for of in &trial.materials.binary {
        row(FRICTION, message!(FRICTION_OF, first = &of.id1, second = &of.id2, value = of.kinetic_friction));
    }
    let walls = &trial.geometry.walls;
    let length = walls.iter().flat_map(|wall| wall.corners.windows(2)).map(|side| (side[1] - side[0]).norm()).sum::<f64>();
    row(WALL_LENGTH, message!(LENGTH_OF, count = walls.len(), length));
    let parameters = &trial.parameters;
    row(STEPS, message!(STEPS_OF, step = parameters.time_step, mechanical = parameters.time_step_mechanical));
}
