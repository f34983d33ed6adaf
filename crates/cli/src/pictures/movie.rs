//! `lemons movie`: the scene over time.

use super::source::{KeptFrames, RunSource};
use super::style::{Scenes, StyleArguments};
use super::trial_run::TrialRun;
use crate::error::Misused;
use crate::files::ForceOption;
use crate::interrupt::Interrupt;
use crate::output::Output;
use crate::values::{positive, seconds, within};
use anyhow::{Context, Result, bail};
use crowd_mechanics::model_description::DEFAULT_STOP_TIME;
use lemons_core::files::{Scratch, Staged, input};
use lemons_picture::{Animation, AnimationFormat, PictureScene, Pixels, Style, pixels, svg};
use lemons_results::Frame;
use lemons_sim::Until;
use lemons_sim::stop::REST;
use rayon::prelude::*;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};

/// Frames that are drawn at once, by all processors.
const BATCH: usize = 16;
/// Longer movies are a mistake.
const MOST_FRAMES: f64 = 100_000.0;
/// \[1/s\]
const MOST_OF_GIF: f64 = 50.0;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    pub source: RunSource,
    /// File for the movie: MP4 (needs the program ffmpeg), animated PNG or GIF. Default: movie.mp4, or
    /// movie.gif if there is no ffmpeg
    #[arg(short, long, value_name = "FILE.mp4, .png or .gif")]
    output: Option<PathBuf>,
    /// Frames per second of the movie
    #[arg(long, value_name = "FPS", default_value_t = 25.0, value_parser = within(0.1, 240.0, ""))]
    frame_rate: f64,
    /// Seconds of the run per second of the movie: 0.1 is slow motion
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    speed_up: f64,
    /// Start of the movie, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    from: Option<f64>,
    /// End of the movie, in seconds. The word still: the movie ends when nobody is faster than 1 cm/s or
    /// 0.05 rad/s any more; the simulation of a Trial or FMU then ends after 1 s of standstill, at the
    /// latest after 120 s. The word left: the movie ends when everybody has left; a Trial in which people
    /// walk is run so long, as by lemons run. Default: the end of earlier results; 5 for a Trial or FMU
    #[arg(long, value_name = "SECONDS, still or left", value_parser = until)]
    until: Option<Until>,
    #[command(flatten)]
    _force: ForceOption,
    #[command(flatten)]
    style: StyleArguments,
}

fn until(text: &str) -> Result<Until, String> {
    match text {
        "still" => Ok(Until::Still),
        "left" => Ok(Until::Left),
        _ => positive(text).map(Until::Time).map_err(|must| format!("{must} of seconds, or still or left")),
    }
}

pub fn movie(arguments: &Arguments) -> Result<()> {
    let Arguments { source, style, frame_rate, speed_up, .. } = arguments;
    let path = arguments.output.clone().unwrap_or_else(default_output);
    let format = format_of(&path)?;
    if format == Some(AnimationFormat::Gif) && *frame_rate > MOST_OF_GIF {
        bail!(Misused(format!(
            "--frame-rate {frame_rate}: a GIF shows at most {MOST_OF_GIF} frames per second"
        )));
    }
    if let (Some(from), Some(until)) = (arguments.from, arguments.until.and_then(Until::time))
        && from >= until
    {
        bail!(Misused(format!("--from {from:?} is not before --until {until:?}")));
    }
    style.check(&[])?;
    // Before there is anything that would be left.
    let interrupt = Interrupt::watch();
    let mut file = Output::open(&path)?;
    let until = arguments.until.unwrap_or(Until::Time(DEFAULT_STOP_TIME));
    let run = source.trial_run(source.runs().then_some(until), KeptFrames::All, &interrupt)?;
    let first = arguments.from.unwrap_or(run.run.times().0);
    let last = match arguments.until {
        Some(Until::Time(time) | Until::Point(time)) => time,
        Some(Until::Still) => rest(&run, first)?,
        Some(Until::Left) => left(&run, first)?,
        None => run.run.times().1,
    };
    [first, last].into_iter().try_for_each(|time| run.check(time))?;
    let frames = ((last - first) * frame_rate / speed_up + 1e-9).floor() + 1.0;
    if !(2.0..=MOST_FRAMES).contains(&frames) {
        bail!(
            "from {first:?} to {last:?} s there would be {frames} frames: a movie has from 2 to {MOST_FRAMES} \
             (--frame-rate, --speed-up)"
        );
    }
    let times: Vec<f64> = (0..frames as u64).map(|k| first + k as f64 * speed_up / frame_rate).collect();
    style.note_sampled(&run.run, speed_up / frame_rate);
    let mut scenes = Scenes::new(style, &run, &times, &interrupt)?;
    let of_path = || path.display().to_string();
    let mut shown = |time: &f64| scenes.at(*time);
    // Frames for ffmpeg need even sides.
    let sides = if format.is_none() { 2 } else { 1 };
    let draw =
        |(scene, style): &(PictureScene, Style)| pixels(&svg(scene, style), arguments.style.width, sides);
    // Its size is that of all.
    let first_frame = draw(&shown(&first))?;
    let film = Film::begin(file.writer(), format, *frame_rate, times.len(), &first_frame);
    let mut film = film.with_context(of_path)?;
    let template = "{bar:40} {percent:>3}%  frame {pos} of {len}  {eta} left";
    let progress = crate::print::bar(times.len() as u64, template)?;
    for batch in times.chunks(BATCH) {
        let shown: Vec<(PictureScene, Style)> = batch.iter().map(&mut shown).collect();
        let drawn: Vec<_> = shown.par_iter().map(draw).collect();
        for frame in drawn {
            interrupt.check()?;
            film.add(&frame?).with_context(of_path)?;
            progress.inc(1);
        }
    }
    film.end().with_context(of_path)?;
    file.persist()?;
    progress.finish_and_clear();
    if let Some(still) = run.still_from().filter(|still| still + REST <= last) {
        match told(still) {
            _ if still <= first => note!("nobody moves in this movie"),
            still => note!("nobody moves after t = {still:?} s: to end the movie there, use --until still"),
        }
    }
    say!("{}: {frames} frames, {:.2} s", path.display(), frames / frame_rate)?;
    Ok(())
}

/// \[s\] Where a movie from `first` on ends as all have come to rest.
fn rest(run: &TrialRun, first: f64) -> Result<f64> {
    let source = run.run.source.display();
    match run.still_from() {
        None => {
            let (_, last) = run.run.times();
            note!("{source}: somebody still moves at t = {:?} s: the movie ends there", told(last));
            Ok(last)
        }
        Some(still) if still <= first => {
            bail!("--until still: {source}: nobody moves after t = {:?} s: nothing to show", told(first))
        }
        Some(still) => Ok(still),
    }
}

/// \[s\] Where a movie from `first` on ends as the last one leaves: the first frame with those who stay.
fn left(run: &TrialRun, first: f64) -> Result<f64> {
    let (source, frames) = (run.run.source.display(), &run.run.frames);
    let there = |frame: &Frame| frame.present().count();
    let stay = frames.last().map_or(0, there);
    let Some(before) = frames.iter().rposition(|frame| there(frame) != stay) else {
        bail!("--until left: {source}: nobody leaves")
    };
    let time = frames[before + 1].time;
    if time <= first {
        bail!("--until left: {source}: nobody leaves after t = {:?} s: nothing to show", told(first));
    }
    if stay > 0 {
        note!(
            "{source}: {stay} of {} people stay: the movie ends at t = {:?} s, when the last of the others has left",
            run.run.ids.len(),
            told(time)
        );
    }
    Ok(time)
}

/// \[s\] A time as it is told: without what rounding has added.
fn told(time: f64) -> f64 {
    (time * 1e6).round() / 1e6
}

/// Returns the format of a file's name; `None`: MP4, which ffmpeg makes.
fn format_of(path: &Path) -> Result<Option<AnimationFormat>> {
    match path.extension().and_then(|end| end.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("mp4") if ffmpeg_is_there() => Ok(None),
        Some("mp4") => bail!(
            "{}: MP4 needs the program ffmpeg, which is not there; .png (animated PNG) and .gif need nothing",
            path.display()
        ),
        Some("png" | "apng") => Ok(Some(AnimationFormat::Apng)),
        Some("gif") => Ok(Some(AnimationFormat::Gif)),
        _ => bail!(Misused(format!("{}: movies are .mp4, .png or .gif", path.display()))),
    }
}

fn default_output() -> PathBuf {
    PathBuf::from(if ffmpeg_is_there() { "movie.mp4" } else { "movie.gif" })
}

fn ffmpeg_is_there() -> bool {
    let mut asked = Command::new("ffmpeg");
    asked.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    asked.status().is_ok_and(|status| status.success())
}

/// A movie being written; all its frames have one size.
enum Film<'a> {
    Animated(Animation<&'a mut BufWriter<Staged>>),
    Ffmpeg(Ffmpeg, &'a mut BufWriter<Staged>),
}

impl<'a> Film<'a> {
    fn begin(
        file: &'a mut BufWriter<Staged>,
        format: Option<AnimationFormat>,
        frame_rate: f64,
        frames: usize,
        first: &Pixels,
    ) -> Result<Film<'a>> {
        let Some(format) = format else { return Ok(Film::Ffmpeg(Ffmpeg::start(frame_rate, first)?, file)) };
        Ok(Film::Animated(Animation::begin(file, format, frame_rate, u32::try_from(frames)?, first)?))
    }

    fn add(&mut self, frame: &Pixels) -> Result<()> {
        match self {
            Film::Animated(animation) => Ok(animation.add(frame)?),
            Film::Ffmpeg(ffmpeg, _) => ffmpeg.add(frame),
        }
    }

    fn end(self) -> Result<()> {
        match self {
            Film::Animated(animation) => Ok(animation.finish()?),
            Film::Ffmpeg(mut ffmpeg, file) => {
                ffmpeg.wait()?;
                let made = input::open(&ffmpeg.scratch.path().join(MADE)).context("what ffmpeg made");
                std::io::copy(&mut made?, file)?;
                Ok(())
            }
        }
    }
}

/// The running program; ended with the movie, whatever becomes of that.
struct Ffmpeg {
    program: Child,
    /// Takes frames, until their end.
    frames: Option<BufWriter<ChildStdin>>,
    /// Where it writes, and what it says.
    scratch: Scratch,
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// Files in its scratch directory.
const MADE: &str = "movie.mp4";
const LOG: &str = "log";

impl Ffmpeg {
    /// Starts the program for frames of the size of the first.
    fn start(frame_rate: f64, Pixels { width, height, .. }: &Pixels) -> Result<Ffmpeg> {
        // It goes back in the file to put the index first, so it cannot write to a pipe.
        let scratch = Scratch::new().context("cannot make a temporary directory")?;
        let log = File::create(scratch.path().join(LOG)).context("cannot make a temporary file")?;
        let mut program = Command::new("ffmpeg");
        // Ctrl-C is for this program: it ends ffmpeg by closing its input.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut program, 0);
        let mut program = program
            .args(["-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgba"])
            .args(["-s", &format!("{width}x{height}"), "-r", &frame_rate.to_string(), "-i", "-"])
            // What every player reads; the index first, so that pages play it while it loads.
            .args(["-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-y"])
            .arg(scratch.path().join(MADE))
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(log)
            .spawn()
            .context("cannot start ffmpeg")?;
        let frames = program.stdin.take().map(BufWriter::new);
        Ok(Ffmpeg { program, frames, scratch })
    }

    fn add(&mut self, frame: &Pixels) -> Result<()> {
        match self.frames.as_mut().map_or(Ok(()), |frames| frames.write_all(&frame.rgba)) {
            Ok(()) => Ok(()),
            // It has said why.
            Err(error) => self.wait().and(Err(error).context("ffmpeg")),
        }
    }

    /// Ends its input, and waits for its end.
    ///
    /// # Errors
    /// It failed, and why.
    fn wait(&mut self) -> Result<()> {
        // A broken pipe is told by ffmpeg itself.
        let _ = self.frames.take().map(BufWriter::into_inner);
        let status = self.program.wait().context("ffmpeg")?;
        if !status.success() {
            let log = self.scratch.path().join(LOG);
            let text = input::read_text(&log, input::LARGEST_SETTINGS).context("ffmpeg")?;
            bail!("ffmpeg ({status}): {}", text.trim());
        }
        Ok(())
    }
}
