//! Files that `lemons crowd` writes beside the Trial, and `lemons person`: tables, meshes, pictures.

use crate::error::and_then;
use crate::output::Output;
use crate::pictures::plot::PictureFormat;
use anyhow::Result;
use lemons_core::files::Staged;
use lemons_core::trial::Trial;
use lemons_picture::{Fill, PictureScene, Style, svg};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// \[px\]
pub const PICTURE_WIDTH: u32 = 1200;

/// Files that appear when all is done.
pub struct Outputs(Vec<File>);

struct File {
    option: &'static str,
    /// As the summary calls it; empty if it names only the path.
    what: &'static str,
    output: Output,
}

impl Outputs {
    /// Opens the files that are wanted: options, what is written, paths.
    pub fn open(all: &[(&'static str, &'static str, &Option<PathBuf>)]) -> Result<Outputs> {
        let wanted = all.iter().filter_map(|&(option, what, path)| Some((option, what, path.as_deref()?)));
        let open = wanted.map(|(option, what, path)| Ok(File { option, what, output: Output::open(path)? }));
        Ok(Outputs(open.collect::<Result<_>>()?))
    }

    pub fn of(&mut self, option: &str) -> Option<&mut Output> {
        self.0.iter_mut().find(|file| file.option == option).map(|file| &mut file.output)
    }

    /// Writes the file of an option, if it is wanted.
    pub fn fill<F>(&mut self, option: &str, write: F) -> Result<()>
    where
        F: FnOnce(&mut BufWriter<Staged>) -> io::Result<()>,
    {
        self.of(option).map_or(Ok(()), |output| output.fill(write))
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns whether the file of one of these options is wanted.
    pub fn have_any(&self, options: &[&str]) -> bool {
        self.0.iter().any(|file| options.contains(&file.option))
    }

    /// Draws the pictures that are wanted.
    pub fn draw(&mut self, scene: &PictureScene, style: &Style) -> Result<()> {
        for (option, format) in
            [("--svg", PictureFormat::Svg), ("--pdf", PictureFormat::Pdf), ("--png", PictureFormat::Png)]
        {
            if let Some(output) = self.of(option) {
                let picture = format.bytes(svg(scene, style), PICTURE_WIDTH)?;
                output.fill(|file| file.write_all(&picture))?;
            }
        }
        Ok(())
    }

    /// Puts each in its place, also when that of another cannot be taken.
    pub fn persist(self, goes_on: impl Fn() -> Result<()>, out: &mut impl Write) -> Result<()> {
        let mut done = Ok(());
        for File { what, output, .. } in self.0 {
            goes_on()?;
            let path = output.path().to_owned();
            let placed = output.persist().and_then(|()| Ok(say(out, what, &path)?));
            done = and_then(done, placed);
        }
        done
    }
}

/// Returns the picture of a crowd as its Trial has it.
pub fn of_crowd(trial: &Trial) -> (PictureScene<'_>, Style) {
    let kinds = trial.agents.iter().any(|agent| agent.kind.is_some());
    let fill = if kinds { Fill::Kind } else { Fill::BodyArea };
    (PictureScene::at_start(trial), Style { width: PICTURE_WIDTH.into(), fill, ..Style::default() })
}

/// Says what was written where.
pub fn say(out: &mut impl Write, what: &str, path: &Path) -> io::Result<()> {
    let path = path.display();
    if what.is_empty() { writeln!(out, "{path}") } else { writeln!(out, "{what:<18} {path}") }
}
