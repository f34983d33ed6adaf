//! What a report contains.

use crate::seen::{Moment, RunSeen, SAMPLE};
use crate::sentences::*;
use crate::{Block, Report, Section};
use lemons_core::message::{Message, Sentence, message};
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::{Agent, Incline, Trial};
use lemons_decision::rule::UNLIMITED;
use lemons_decision::target::Target;
use lemons_decision::{Plan, Spread};
use lemons_picture::{
    Chart, ChartPanel, ChartStyle, ColourMap, Curve, DENSITY_KERNEL, DensityMap, Fill, LoadMap, PictureScene,
    Style, Values, chart_svg, svg,
};
use lemons_results::measure::{
    Across, Exposed, Flow, LATEST, Leaving, MeanInterval, Over, Panel, Passage, SPANS, WallLoad,
};
use std::collections::BTreeMap;

/// Panels that are listed.
const MOST_PANELS: usize = 10;
/// Runs of which it is told at the top what is wrong.
const MOST_NOTICES: usize = 10;
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
    /// By which the same documents are known again; empty: not known.
    pub digest: String,
    /// The program with its version.
    pub program: String,
    /// Whom people are drawn from.
    pub people: Message,
    /// How a drawing was read: what, and how.
    pub drawing: Vec<(String, String)>,
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
            (
                PLAN,
                vec![drawn(
                    message!(THE_PLAN, seed = many.seed_of(first)),
                    &first.scene(None),
                    Style::default(),
                )],
            ),
            (PEOPLE, vec![people(&first.trial, many.seed_of(first))]),
            (ASSUMED, many.assumed(first)),
            (LEAVING, many.leaving(first)),
            (CROWDING, many.density()),
            (PRESSING, many.squeeze()),
            (WALLS, many.loads()),
            (WARNINGS, vec![many.warnings()]),
            (LIMITS, vec![many.limits()]),
            (VERSIONS, vec![many.versions()]),
        ];
        let sections = sections.into_iter().filter(|(_, blocks)| !blocks.is_empty());
        let section = |(heading, blocks)| Section { heading: Message::new(heading, &[]), blocks };
        Report {
            title: told.title.clone(),
            notices: many.notices(),
            sections: sections.map(section).collect(),
        }
    }
}

/// A number of a run, and where it is from.
struct Found(f64, Message);

impl From<f64> for Found {
    fn from(value: f64) -> Found {
        Found(value, Message::default())
    }
}

impl From<(f64, Message)> for Found {
    fn from((value, at): (f64, Message)) -> Found {
        Found(value, at)
    }
}

fn number(value: f64, decimals: usize) -> Message {
    format!("{value:.decimals$}").into()
}

fn plain(sentence: Sentence) -> Message {
    Message::new(sentence, &[])
}

fn heads<const N: usize>(all: [Sentence; N]) -> Vec<Message> {
    all.map(plain).to_vec()
}

/// Returns the run in which a moment has the greatest value, and the moment.
fn worst(runs: &[RunSeen], of: fn(&RunSeen) -> Option<&Moment>) -> Option<(&RunSeen, &Moment)> {
    let all = runs.iter().filter_map(|run| Some((run, of(run)?)));
    all.max_by(|a, b| a.1.value.total_cmp(&b.1.value))
}

/// Says why a run ended.
fn ended(run: &RunSeen) -> Sentence {
    match run.leaving.as_ref().map(Leaving::over) {
        Some(Some(Over::Left)) => WHEN_LEFT,
        Some(Some(Over::Standstill)) => STANDSTILL,
        Some(None) => AT_LATEST,
        None => TIMED,
    }
}

/// Runs of one scenario.
struct Many<'a> {
    runs: &'a [RunSeen],
    told: &'a Told,
}

impl Many<'_> {
    /// Returns the seed of a run, where there are several runs.
    fn seed(&self, run: &RunSeen) -> Option<usize> {
        run.seed.filter(|_| self.runs.len() > 1).map(|seed| seed as usize)
    }

    /// Returns it in words.
    fn seed_of(&self, run: &RunSeen) -> Message {
        self.seed(run).map_or(Message::default(), |seed| message!(OF_SEED, seed))
    }

    /// Says in which run something was found, where there are several.
    fn in_run(&self, run: &RunSeen, finding: Message) -> Message {
        self.seed(run).map_or(finding.clone(), |seed| message!(IN_RUN, seed, finding))
    }

    /// Returns so many runs in words.
    fn count(&self, runs: usize) -> Message {
        if runs == 1 { plain(SINGLE) } else { message!(SEVERAL, runs) }
    }

    /// Returns the row of a quantity: of one run its value, else mean, interval, least and greatest.
    fn row<F: Into<Found>>(
        &self,
        label: Message,
        (unit, decimals): (&str, usize),
        of: impl Fn(&RunSeen) -> Option<F>,
    ) -> Vec<Message> {
        let found = self.runs.iter().filter_map(|run| Some((run, of(run)?.into())));
        let mut found: Vec<(&RunSeen, Found)> = found.collect();
        found.sort_by(|(_, a), (_, b)| a.0.total_cmp(&b.0));
        let values: Vec<f64> = found.iter().map(|(_, Found(value, _))| *value).collect();
        let shown = |value: Option<f64>| value.map_or("–".into(), |value| number(value, decimals));
        let (least, most) = (values.first().copied(), values.last().copied());
        let at = found.last().map_or(Message::default(), |(run, Found(_, at))| match self.seed(run) {
            // Where all runs have the same, no seed is told.
            Some(seed) if least < most && at.is_empty() => message!(WITH_SEED, seed),
            Some(seed) if least < most => message!(IN_SEED, value = at, seed),
            _ => at.clone(),
        });
        if self.runs.len() == 1 {
            return vec![label, shown(most), unit.into(), at];
        }
        let mean = MeanInterval::of(&values);
        let ends = mean.and_then(|mean| mean.ends()).map_or("–".into(), |[low, high]| {
            message!(TO, low = number(low, decimals), high = number(high, decimals))
        });
        let (mean, runs) = (shown(mean.map(|mean| mean.mean)), values.len().to_string().into());
        vec![label, unit.into(), mean, ends, shown(least), shown(most), at, runs]
    }

    /// Makes a table of such rows.
    fn table(&self, caption: Option<Message>, rows: Vec<Vec<Message>>) -> Block {
        let runs = self.runs.len();
        let (head, usual) = match runs {
            1 => (heads([QUANTITY, VALUE, UNIT, WHERE]), plain(OF_ONE)),
            _ => {
                let head = heads([QUANTITY, UNIT, MEAN, INTERVAL, LEAST, GREATEST, WHERE, RUNS]);
                (head, message!(OF_RUNS, runs))
            }
        };
        Block::table(caption.unwrap_or(usual), head, rows)
    }

    fn notices(&self) -> Vec<Message> {
        let failed = self.told.failed.iter();
        let failed = failed.map(|(seed, why)| message!(FAILED, seed = *seed as usize, why));
        let stayed = self.runs.iter().filter(|run| !run.stay().is_empty()).map(|run| {
            let (mut who, time) = (run.stay(), run.end);
            let (stay, leave) = (who.len(), run.leaving.as_ref().map_or(0, |leaving| leaving.counts().0));
            if who.len() > MOST_NAMES {
                who.truncate(MOST_NAMES);
                who.push("…".into());
            }
            let why = plain(ended(run));
            self.in_run(run, message!(NOT_LEFT, stay, leave, time, why, who = who.join(", ")))
        });
        let late = self.runs.iter().map(|run| (run, run.leaving.as_ref().map_or(0, Leaving::outside)));
        let late = late.filter(|(_, count)| *count > 0);
        let late = late.map(|(run, count)| self.in_run(run, message!(NOT_COME, count, time = run.end)));
        let mut all: Vec<Message> = failed.chain(stayed).chain(late).collect();
        if let Some(more) = all.len().checked_sub(MOST_NOTICES).filter(|more| *more > 0) {
            all.truncate(MOST_NOTICES);
            all.push(message!(MORE_NOTICES, more));
        }
        if all.is_empty() && self.runs[0].all_left() {
            all.push(message!(ALL_OUT, runs = self.count(self.runs.len())));
        }
        all.extend(Some(self.sample()).filter(|sample| *sample != NOT_SAMPLE).map(plain));
        all
    }

    /// Says of what the numbers are a sample.
    fn sample(&self) -> Sentence {
        let RunSeen { density, exposure, .. } = &self.runs[0];
        match self.runs {
            [_] => ONE_RUN,
            runs if runs.iter().all(|run| run.density == *density && run.exposure == *exposure) => SAME_RUNS,
            _ => NOT_SAMPLE,
        }
    }

    fn results(&self) -> Vec<Block> {
        let first = &self.runs[0];
        let (limit, over) = first.settings.limit;
        let of =
            |run: &RunSeen, agent: usize, time: f64| message!(OF_AT, who = &run.trial.agents[agent].id, time);
        let mut rows = Vec::new();
        if first.leaving.is_some() {
            let left = |run: &RunSeen| run.all_left().then_some(run.end);
            rows.push(self.row(plain(EVACUATION), ("s", 1), left));
            rows.push(self.row(plain(LEFT), ("", 0), |run| Some(run.leaving.as_ref()?.counts().1 as f64)));
            rows.push(self.row(plain(STAY), ("", 0), |run| Some(run.stay().len() as f64)));
            rows.push(self.row(plain(WAIT), ("s", 1), |run| {
                let wait = run.leaving.as_ref()?.longest_wait()?;
                Some((wait.time, of(run, wait.agent, wait.from)))
            }));
        }
        rows.push(self.row(plain(DENSEST), ("1/m²", 1), |run| {
            run.dense.as_ref().map(|of| (of.value, message!(AT, time = of.time)))
        }));
        if !SPANS.contains(&over) {
            rows.push(self.row(message!(SQUEEZE, over), ("N", 0), |run| {
                run.pressed.as_ref().map(|moment| (moment.value, of(run, moment.who, moment.time)))
            }));
        }
        for (k, over) in SPANS.into_iter().enumerate().rev() {
            let label = if k == 0 { plain(SQUEEZE_01) } else { message!(SQUEEZE, over) };
            rows.push(self.row(label, ("N", 0), |run| {
                let all = run.exposure.iter().flatten().enumerate();
                let all =
                    all.filter_map(|(who, one)| Some((one.largest_mean[k]?, who, one.largest_mean_at[k])));
                let (value, who, time) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
                Some((value, of(run, who, time)))
            }));
        }
        let each = |run: &RunSeen, of: fn(&Exposed) -> Option<f64>| -> Option<Vec<f64>> {
            run.exposure.as_ref()?.iter().map(of).collect()
        };
        rows.push(self.row(plain(SQUEEZE_90), ("N", 0), |run| {
            // Who never came was not squeezed.
            let came = run.exposure.as_ref()?.iter().filter(|one| one.time > 0.0);
            let squeezes: Option<Vec<f64>> = came.map(|one| one.largest_mean[1]).collect();
            Across::Quantile90.of(squeezes?.into_iter())
        }));
        rows.push(self.row(message!(ABOVE, limit, over), ("", 0), |run| {
            let first = each(run, |one| Some(one.above[0]?.first.unwrap_or(f64::INFINITY)))?;
            let first: Vec<f64> = first.into_iter().filter(|time| time.is_finite()).collect();
            let time = Across::Min.of(first.iter().copied());
            Some((first.len() as f64, time.map_or(Message::default(), |time| message!(AT, time))))
        }));
        rows.push(self.row(plain(ABOVE_TIME), ("s", 1), |run| {
            Some(each(run, |one| Some(one.above[0]?.time))?.iter().sum::<f64>())
        }));
        rows.push(self.row(plain(ABOVE_LONGEST), ("s", 2), |run| {
            Across::Max.of(each(run, |one| Some(one.above[0]?.longest))?.into_iter())
        }));
        if first.fallen.is_some() {
            rows.push(self.row(plain(FELL), ("", 0), |run| run.fallen.map(|fallen| fallen as f64)));
        }
        rows.push(self.row(plain(OVERLAP), ("mm", 1), |run| Some(1e3 * run.overlap)));
        vec![self.table(None, rows)]
    }

    fn assumed(&self, first: &RunSeen) -> Vec<Block> {
        let RunSeen { trial, plan, settings, .. } = first;
        // They follow each other.
        let ends = [self.runs.first(), self.runs.last()].map(|run| run.and_then(|run| run.seed));
        let seeds = match ends {
            [Some(first), Some(last)] if first < last => format!("{first} – {last}"),
            [first, _] => first.map_or(String::new(), |first| first.to_string()),
        };
        let time = settings.until.latest();
        let until =
            if first.leaving.is_some() { message!(UNTIL_LEFT, time) } else { message!(UNTIL_TIME, time) };
        let mut rows = vec![(plain(SEEDS), seeds.into()), (plain(UNTIL), until)];
        rows.push((plain(BODIES_FROM), self.told.people.clone()));
        of_plan(plan.as_ref(), &mut rows);
        of_trial(trial, &mut rows);
        of_ground(trial, plan.as_ref(), &mut rows);
        let text = |pairs: &[(String, String)]| -> Vec<(Message, Message)> {
            pairs.iter().map(|(key, value)| (key.as_str().into(), value.as_str().into())).collect()
        };
        let (settings, drawing) = (text(&self.told.settings), text(&self.told.drawing));
        let all = [(ASSUMPTIONS, rows), (SETTINGS, settings), (DRAWING, drawing)];
        all.into_iter()
            .filter(|(_, rows)| !rows.is_empty())
            .map(|(caption, rows)| facts(caption, rows))
            .collect()
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
            let time = |of: Option<&Passage>| of.map(|of| of.time);
            rows.push(self.row(message!(BY_PEOPLE, exit), ("", 0), |run| Some(of(run).len() as f64)));
            rows.push(self.row(message!(BY_FLOW, exit), ("1/s", 3), |run| Flow::of(&of(run)).rate));
            rows.push(self.row(message!(BY_FIRST, exit), ("s", 1), |run| time(of(run).first())));
            rows.push(self.row(message!(BY_LAST, exit), ("s", 1), |run| time(of(run).last())));
        }
        if rows.is_empty() || first.leaving.is_none() {
            return Vec::new();
        }
        let curve = |(group, run): (usize, &RunSeen)| {
            let gone = run.departures.iter().enumerate().map(|(n, (time, _))| (*time, (n + 1) as f64));
            let points = [(0.0, 0.0)].into_iter().chain(gone).chain([(run.end, run.departures.len() as f64)]);
            let name = run.seed.map_or(String::new(), |seed| seed.to_string());
            Curve { name, points: points.collect(), group, dashed: false }
        };
        let lines = self.runs.iter().enumerate().map(curve).collect();
        let panel = ChartPanel { y: "people who have left".into(), lines, steps: true };
        let chart = Chart { x: "time (s)".into(), panels: vec![panel], noun: "seed".into() };
        let svg = chart_svg(&chart, &ChartStyle { width: WIDTH, aspect: Some(0.3), ..ChartStyle::default() });
        vec![self.table(Some(plain(EXITS)), rows), Block::Picture { caption: plain(CURVE), svg }]
    }

    fn density(&self) -> Vec<Block> {
        let Some((run, moment)) = worst(self.runs, |run| run.dense.as_ref()) else { return Vec::new() };
        let Moment { time, value, ref poses, .. } = *moment;
        let mut map = DensityMap::new(run.density.view(), DENSITY_KERNEL, &run.trial.geometry.walls);
        map.add(poses.iter().map(|pose| pose.position));
        let (sample, kernel) = (SAMPLE, DENSITY_KERNEL);
        let caption = message!(WORST_DENSITY, time, seed = self.seed_of(run), sample, value, kernel);
        let mut scene = run.scene(Some(poses.clone()));
        scene.density = Some(map);
        let then = drawn(caption, &scene, Style { time: Some(time), ..Style::default() });
        let first = &self.runs[0];
        let mut mean = first.density.clone();
        // People without walls begin elsewhere with each seed: there is no common map.
        let same = self.runs.iter().skip(1).filter(|run| run.density.view() == first.density.view());
        let runs = 1 + same.map(|run| mean.join(&run.density)).count();
        let caption = message!(MEAN_DENSITY, runs = self.count(runs), sample, kernel);
        let mut scene = first.scene(Some(Vec::new()));
        scene.density = Some(mean);
        vec![then, drawn(caption, &scene, Style::default())]
    }

    /// Says how each run ended, and who was pressed most in it.
    fn squeeze(&self) -> Vec<Block> {
        let (_, over) = self.runs[0].settings.limit;
        let row = |run: &RunSeen| {
            let seed = run.seed.map_or("–".to_owned(), |seed| seed.to_string());
            let begin =
                [seed.into(), number(run.end, 1), plain(ended(run)), run.stay().len().to_string().into()];
            let Some(Moment { time, value, who, by_walls, poses, .. }) = &run.pressed else {
                return begin.into_iter().chain(["–"; 6].map(Message::from)).collect();
            };
            let (at, Agent { id, kind, .. }) = (poses[*who].position, &run.trial.agents[*who]);
            let who = kind.as_ref().map_or(id.clone(), |kind| format!("{id} ({kind})"));
            let numbers = [(*value, 0), (100.0 * by_walls / value, 0), (*time, 2), (at.x, 2), (at.y, 2)];
            let numbers = numbers.map(|(value, decimals)| number(value, decimals));
            begin.into_iter().chain([who.into()]).chain(numbers).collect()
        };
        let head = [SEED, ENDED, WHY, NOT_OUT, PERSON, NEWTONS, BY_WALLS, TIME, PLACE_X, PLACE_Y];
        let table = Block::table(message!(PRESSED, over), heads(head), self.runs.iter().map(row).collect());
        let Some((run, moment)) = worst(self.runs, |run| run.pressed.as_ref()) else { return vec![table] };
        let Moment { time, value, who, ref poses, ref values, .. } = *moment;
        let (seed, who) = (self.seed_of(run), &run.trial.agents[who].id);
        let caption = message!(WORST_SQUEEZE, time, seed, over, value, who);
        let values = Values { map: ColourMap::FromGrey, ..Values::of(values.clone(), "mean squeeze", "N") };
        let (fill, range) = (Fill::Values(values), Some((0.0, value)));
        let style = Style { fill, time: Some(time), range, ..Style::default() };
        vec![table, drawn(caption, &run.scene(Some(poses.clone())), style)]
    }

    fn loads(&self) -> Vec<Block> {
        let first = &self.runs[0];
        let Some(loads) = &first.loads else { return Vec::new() };
        let panel = |k: usize| &loads.panels[k].0;
        type Load = fn(&WallLoad) -> Option<(f64, f64)>;
        // Of a panel that is another one in another run, there is no number.
        let of = |run: &RunSeen, k: usize, load: Load| {
            let (own, seen) = run.loads.as_ref()?.panels.get(k)?;
            let at = |time: f64| if time.is_nan() { Message::default() } else { message!(AT, time) };
            load(seen).filter(|_| own == panel(k)).map(|(load, time)| (load / 1e3, at(time)))
        };
        let kinds: [(Sentence, Load); 3] = [
            (LOAD_1, |load| load.load_1.zip(load.load_1_at)),
            (LOAD_10, |load| load.load_10.zip(load.load_10_at)),
            // A peak of 0 has no time.
            (LOAD_PEAK, |load| Some((load.load_peak?, load.load_peak_at.unwrap_or(f64::NAN)))),
        ];
        let greatest = |k: usize| {
            let all = self.runs.iter().filter_map(|run| Some(of(run, k, kinds[0].1)?.0));
            Across::Max.of(all).unwrap_or(f64::NAN)
        };
        let greatest: Vec<f64> = (0..loads.panels.len()).map(greatest).collect();
        let mut order: Vec<usize> = (0..greatest.len()).filter(|k| greatest[*k] > 0.0).collect();
        order.sort_by(|a, b| greatest[*b].total_cmp(&greatest[*a]));
        if order.is_empty() {
            return vec![Block::Text { text: plain(NO_LOAD) }];
        }
        let (count, all) = (order.len().min(MOST_PANELS), order.len());
        let rows = order.iter().take(count).enumerate().flat_map(|(place, &k)| {
            let Panel { wall, .. } = panel(k);
            let [from, to] = panel(k).ends();
            let [x, y]: [f64; 2] = ((from + to) * 0.5).into();
            let length = panel(k).length();
            // Of those that are less loaded, only the mean of a second.
            kinds.into_iter().take(if place < 3 { 3 } else { 1 }).map(move |(name, load)| {
                let label = message!(PANEL, wall, x, y, length, what = plain(name));
                self.row(label, ("kN/m", 2), |run| of(run, k, load))
            })
        });
        let table = self.table(Some(message!(LOADED, count, all)), rows.collect());
        let values = Values::of(greatest, "greatest mean load over 1 s", "kN/m");
        let (panels, values) = (
            loads.panels.iter().map(|(panel, _)| panel.ends()).collect(),
            Values { map: ColourMap::FromPaper, ..values },
        );
        let mut scene = first.scene(Some(Vec::new()));
        scene.loads = Some(LoadMap { panels, values });
        let runs = self.count(self.runs.len());
        let picture = drawn(message!(LOAD_MAP, runs = &runs), &scene, Style::default());
        vec![table, Block::List { items: vec![plain(DESIGN_LOADS), message!(NO_DESIGN, runs)] }, picture]
    }

    fn warnings(&self) -> Block {
        let found = self.runs.iter().flat_map(|run| run.findings.iter().map(move |finding| (run, finding)));
        let found = found.map(|(run, finding)| self.in_run(run, finding.clone()));
        let items: Vec<Message> = self.told.warnings.iter().cloned().chain(found).collect();
        if items.is_empty() { Block::Text { text: plain(NO_WARNINGS) } } else { Block::List { items } }
    }

    fn limits(&self) -> Block {
        let injury = message!(NOT_INJURY, limit = self.runs[0].settings.limit.0);
        let all = [self.sample(), NOT_SURVEY, NOT_PLANE, NOT_PROOF].map(plain);
        Block::List { items: all.into_iter().chain([injury]).collect() }
    }

    fn versions(&self) -> Block {
        let Told { source, digest, program, .. } = self.told;
        let rows = [(PROGRAM, program), (DATA, source), (DIGEST, digest)];
        facts(MADE, rows.map(|(name, value)| (plain(name), value.as_str().into())).to_vec())
    }
}

/// Makes a table of names and values, without those that are not known.
fn facts(caption: Sentence, rows: Vec<(Message, Message)>) -> Block {
    let known = rows.into_iter().filter(|(_, value)| !value.is_empty());
    Block::table(plain(caption), Vec::new(), known.map(|(name, value)| vec![name, value]).collect())
}

/// Draws a scene.
fn drawn(caption: Message, scene: &PictureScene, style: Style) -> Block {
    Block::Picture { caption, svg: svg(scene, &Style { width: WIDTH, orientation: false, ..style }) }
}

/// Returns two ends as one number, if they are.
fn range(least: f64, most: f64, decimals: usize) -> String {
    let [least, most] = [least, most].map(|value| format!("{value:.decimals$}"));
    if least == most { least } else { format!("{least} – {most}") }
}

/// Least, greatest and mean; zeros without values.
fn spread(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let values: Vec<f64> = values.collect();
    [Across::Min, Across::Max, Across::Mean]
        .map(|across| across.of(values.iter().copied()).unwrap_or_default())
}

/// Says who the people are.
fn people(trial: &Trial, seed: Message) -> Block {
    let mut kinds: BTreeMap<Option<&str>, Vec<&Agent>> = BTreeMap::new();
    trial.agents.iter().for_each(|agent| kinds.entry(agent.kind.as_deref()).or_default().push(agent));
    let row = |name: Message, agents: &[&Agent]| {
        let [least, most, mean] = spread(agents.iter().map(|agent| agent.mass));
        let [.., height] = spread(agents.iter().filter_map(|agent| agent.height));
        vec![
            name,
            agents.len().to_string().into(),
            number(mean, 1),
            range(least, most, 0).into(),
            number(height, 2),
        ]
    };
    let named = |kind: &Option<&str>| kind.map_or(plain(NO_KIND), Message::from);
    let mut rows: Vec<_> = kinds.iter().map(|(kind, agents)| row(named(kind), agents)).collect();
    if rows.len() > 1 {
        rows.push(row(plain(ALL_PEOPLE), &trial.agents.iter().collect::<Vec<_>>()));
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
    let [least, most, mean] = spread(walkers().map(|walker| walker.desired_speed));
    row(SPEED, message!(SPEEDS, range = range(least, most, 2), mean));
    let [least, most, _] = spread(walkers().map(|walker| walker.push));
    let limited = || message!(PUSHES, range = range(least, most, 0));
    row(PUSH, if most >= UNLIMITED { plain(ANY_PUSH) } else { limited() });
    let lean = plan.queue.as_ref().map(|(queue, _)| match queue.push {
        Spread::Same(push) => push.to_string(),
        Spread::Drawn(from) => format!("0 – {}", from.max()),
    });
    row(LEAN, lean.map_or(plain(NO), |push| message!(PUSHES, range = push)));
    let [least, most, _] = spread(walkers().map(|walker| walker.start));
    row(STARTS, format!("{} s", range(least, most, 1)).into());
    row(GROUPS, plan.groups.len().to_string().into());
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
        let place = times.fold(place, |place, &[from, to]| match to {
            // Later than any run.
            LATEST.. => message!(OPENS, place, from),
            _ => message!(OPEN, place, from, to),
        });
        rows.push((message!(EXIT, name), place));
    }
}

/// Says what bodies and walls are like.
fn of_trial(trial: &Trial, rows: &mut Vec<(Message, Message)>) {
    let mut row = |name: Sentence, value: Message| rows.push((plain(name), value));
    let [least, most, _] = spread(trial.agents.iter().map(|agent| agent.shapes.len() as f64));
    row(BODIES, message!(DISKS, range = range(least, most, 0)));
    let moduli = trial.materials.intrinsic.iter();
    let moduli = moduli.map(|of| format!("{:?}: {:e}, {:e} N/m", of.id, of.young_modulus, of.shear_modulus));
    row(MATERIALS, moduli.collect::<Vec<_>>().join("; ").into());
    let pairs = trial.materials.binary.iter();
    let pairs = pairs.map(|of| format!("{:?} – {:?}: {}", of.id1, of.id2, of.kinetic_friction));
    row(FRICTION, pairs.collect::<Vec<_>>().join("; ").into());
    let walls = &trial.geometry.walls;
    let length = walls.iter().flat_map(|wall| wall.sides()).map(|[from, to]| (to - from).norm()).sum::<f64>();
    row(WALL_LENGTH, message!(LENGTH_OF, count = walls.len(), length));
    let (step, mechanical) = (trial.parameters.time_step, trial.parameters.time_step_mechanical);
    row(STEPS, message!(STEPS_OF, step, mechanical));
}

/// Says where the ground is not level, and who comes later.
fn of_ground(trial: &Trial, plan: Option<&Plan>, rows: &mut Vec<(Message, Message)>) {
    for ground in &trial.geometry.grounds {
        let value = match ground.incline {
            Incline::Slope { angle, held } => message!(SLOPE, angle = angle.to_degrees(), held),
            Incline::Stairs { riser, tread } => message!(STAIRS, riser, tread),
        };
        rows.push((message!(GROUND, id = &ground.id), value));
    }
    if !trial.geometry.links.is_empty() {
        rows.push((plain(LINKS), trial.geometry.links.len().to_string().into()));
    }
    for source in plan.iter().flat_map(|plan| &plan.sources) {
        let [first, last, _] = spread(source.times.iter().copied());
        let count = source.people.len();
        rows.push((message!(SOURCE, name = &source.name), message!(COME, count, first, last)));
    }
    for target in plan.iter().flat_map(|plan| &plan.targets) {
        if let Some(most) = target.most {
            rows.push((message!(EXIT, name = &target.name), message!(MOST, most = most as usize)));
        }
    }
}
