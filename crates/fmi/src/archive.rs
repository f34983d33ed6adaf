//! Writes an `.fmu`. The same content gives the same bytes, so that FMUs can be compared.

use crate::{Model, Version};
use lemons_core::files::input;
use lemons_core::files::source::{FileSource, LocalFiles};
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Why an FMU could not be written.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum ArchiveError {
    #[error("no binary was given: an FMU needs at least one")]
    NoBinary,
    #[error(
        "{0:?} is not a platform of this version of FMI (linux64, win64, darwin64, aarch64-linux, …; in FMI 3.0 also \
         wasm32-wasip2)"
    )]
    Platform(String),
    #[error("cannot read {path}: {error}")]
    Read { path: PathBuf, error: std::io::Error },
    #[error("cannot be written: {0}")]
    Write(#[from] std::io::Error),
    #[error("cannot be written: {0}")]
    Zip(#[from] zip::result::ZipError),
}

/// A shared library for one platform.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Binary {
    /// The platform's name in FMI: "linux64", "win64", "darwin64", …
    pub platform: String,
    /// The library.
    pub path: PathBuf,
}

impl Binary {
    /// The file [`THIRD_PARTY`] beside it, or in the directory above, where releases have it.
    pub fn third_party(&self) -> Option<PathBuf> {
        self.third_party_in(&LocalFiles)
    }

    fn third_party_in(&self, files: &dyn FileSource) -> Option<PathBuf> {
        let beside = self.path.parent()?;
        // Above `linux64` is the working directory, above that and above `..` is what `..` leads to.
        let above = beside.parent().filter(|_| beside.file_name().is_some());
        let above = above.map_or_else(|| beside.join(".."), Path::to_owned);
        [beside, &above]
            .map(|directory| directory.join(THIRD_PARTY))
            .into_iter()
            .find(|path| !files.lacks(path))
    }
}

/// The platforms: the names that FMI 2.0 and FMI 3.0 give their directories, and the extension of shared libraries.
/// Either name may be given.
const PLATFORMS: [(&str, &str, &str); 9] = [
    ("linux64", "x86_64-linux", "so"),
    ("linux32", "x86-linux", "so"),
    ("aarch64-linux", "aarch64-linux", "so"),
    ("x86_64-linux", "x86_64-linux", "so"),
    ("win64", "x86_64-windows", "dll"),
    ("win32", "x86-windows", "dll"),
    ("darwin64", "x86_64-darwin", "dylib"),
    ("aarch64-darwin", "aarch64-darwin", "dylib"),
    ("x86_64-darwin", "x86_64-darwin", "dylib"),
];

/// The platform of WebAssembly components, of FMI-LS-WASM (a draft).
pub const COMPONENT: &str = "wasm32-wasip2";
const COMPONENT_MANIFEST: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiLayeredStandardManifest
  xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
  fmi-ls:fmi-ls-name="org.modelica.fmi-ls-wasm"
  fmi-ls:fmi-ls-version="0.1.0"
  fmi-ls:fmi-ls-description="FMI Layered Standard for WebAssembly"/>
"#;

/// Returns the directory of a platform's binary, and its extension.
fn platform(name: &str, version: Version) -> Option<(&'static str, &'static str)> {
    if name == COMPONENT {
        return (version == Version::V3).then_some((COMPONENT, "wasm"));
    }
    let row = PLATFORMS.iter().find(|row| row.0 == name).or(PLATFORMS.iter().find(|row| row.1 == name))?;
    Some((if version == Version::V2 { row.0 } else { row.1 }, row.2))
}

/// Returns the platforms for which libraries are made, by the names of FMI 2.0, and where FMI 2.0 has none, of FMI 3.0.
pub fn platforms() -> impl Iterator<Item = &'static str> {
    // FMI 2.0 and FMI 3.0 have a name each for the platforms of most libraries.
    PLATFORMS.iter().map(|row| row.0).filter(|name| !["x86_64-linux", "x86_64-darwin"].contains(name))
}

/// Returns the file name of a shared library on a platform of FMI.
pub fn library_file(name: &str, platform: &str) -> Option<String> {
    let (_, extension) = self::platform(platform, Version::V2)?;
    Some(format!("{}{name}.{extension}", if extension == "dll" { "" } else { "lib" }))
}

/// Returns the FMI name of the platform on which this program runs, if it has one.
pub fn host_platform() -> Option<&'static str> {
    let system = std::env::consts::OS.replace("macos", "darwin");
    let own = format!("{}-{system}", std::env::consts::ARCH);
    PLATFORMS.iter().find(|row| row.1 == own).map(|row| row.0)
}

/// Returns the name that FMI 3.0 gives the directory of this platform's binary.
pub fn host_directory() -> Option<&'static str> {
    platform(host_platform()?, Version::V3).map(|(directory, _)| directory)
}

/// Names what is linked into released libraries, with the licences.
pub const THIRD_PARTY: &str = "THIRD-PARTY.txt";

/// An FMU being written.
pub struct FmuWriter<W: Write + Seek> {
    zip: ZipWriter<W>,
}

/// The content of an FMU, apart from its resources.
pub struct FmuContent<'a> {
    /// Version of FMI.
    pub version: Version,
    /// `modelDescription.xml`
    pub description: &'a str,
    /// `documentation/index.html`
    pub documentation: &'a str,
    /// The binaries, at least one. The first one's [`THIRD_PARTY`] is added, if there is one.
    pub binaries: &'a [Binary],
    /// `terminalsAndIcons/terminalsAndIcons.xml`
    pub terminals: String,
    /// The icon, a square: in `terminalsAndIcons`.
    pub icon: FmuPicture,
    /// Inputs and outputs, as FMI 3.0 wants them: `documentation/diagram.png`, which FMI 2.0 does not forbid.
    pub diagram: FmuPicture,
    /// A picture of what is packed: `model.png`, which is the icon if there is none; in FMI 3.0
    /// `documentation/model.png`.
    pub picture: Option<Vec<u8>>,
}

/// A drawing. Importers need the PNG; some prefer the SVG.
#[derive(Debug, Clone, Copy)]
pub struct FmuPicture {
    /// `NAME.svg`
    pub svg: &'static str,
    /// `NAME.png`: the same drawing.
    pub png: &'static [u8],
}

impl<W: Write + Seek> FmuWriter<W> {
    /// Starts the archive of a model's FMU, with binaries that are in these files. What follows are the resources.
    ///
    /// # Errors
    /// There is no binary, or one cannot be read; the archive cannot be written.
    pub fn begin<M: Model>(
        file: W,
        files: &dyn FileSource,
        content: &FmuContent<'_>,
    ) -> Result<FmuWriter<W>, ArchiveError> {
        let mut archive = FmuWriter { zip: ZipWriter::new(file) };
        archive.add("modelDescription.xml", content.description.as_bytes())?;
        archive.add("documentation/index.html", content.documentation.as_bytes())?;
        for (name, text) in LICENSES {
            archive.add(&format!("documentation/licenses/{name}"), text.as_bytes())?;
        }
        let first = content.binaries.first().ok_or(ArchiveError::NoBinary)?;
        for binary in content.binaries {
            let (platform, extension) = platform(&binary.platform, content.version)
                .ok_or_else(|| ArchiveError::Platform(binary.platform.clone()))?;
            let name = format!("binaries/{platform}/{}.{extension}", M::IDENTIFIER);
            archive.add(&name, &read(files, &binary.path)?)?;
        }
        if content.binaries.iter().any(|binary| binary.platform == COMPONENT) {
            archive.add("extra/org.modelica.fmi-ls-wasm/manifest.xml", COMPONENT_MANIFEST.as_bytes())?;
        }
        if let Some(path) = first.third_party_in(files) {
            archive.add(&format!("documentation/licenses/{THIRD_PARTY}"), &read(files, &path)?)?;
        }
        archive.add("terminalsAndIcons/terminalsAndIcons.xml", content.terminals.as_bytes())?;
        for (name, drawing) in
            [("terminalsAndIcons/icon", content.icon), ("documentation/diagram", content.diagram)]
        {
            archive.add(&format!("{name}.svg"), drawing.svg.as_bytes())?;
            archive.add(&format!("{name}.png"), drawing.png)?;
        }
        match (content.version, content.picture.as_deref()) {
            (Version::V2, picture) => archive.add("model.png", picture.unwrap_or(content.icon.png))?,
            (Version::V3, Some(picture)) => archive.add("documentation/model.png", picture)?,
            (Version::V3, None) => {}
        }
        Ok(archive)
    }

    /// Adds a file under its name, with forward slashes.
    ///
    /// # Errors
    /// [`ArchiveError`]
    pub fn add(&mut self, name: &str, content: &[u8]) -> Result<(), ArchiveError> {
        // A fixed date: the same content gives the same bytes.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default())
            .unix_permissions(if name.starts_with("binaries/") { 0o755 } else { 0o644 });
        self.zip.start_file(name, options)?;
        Ok(self.zip.write_all(content)?)
    }

    /// Writes the archive's end.
    ///
    /// # Errors
    /// [`ArchiveError`]
    pub fn finish(self) -> Result<(), ArchiveError> {
        self.zip.finish()?;
        Ok(())
    }
}

/// Returns the content of a file.
///
/// # Errors
/// The file cannot be read; the error names it.
pub fn read(files: &dyn FileSource, path: &Path) -> Result<Vec<u8>, ArchiveError> {
    files
        .read(path, input::LARGEST_BINARY)
        .map_err(|error| ArchiveError::Read { path: path.to_owned(), error })
}

/// The first is FMI's entry point.
const LICENSES: [(&str, &str); 3] = [
    ("license.txt", include_str!("license.txt")),
    ("LICENSE-APACHE.txt", include_str!("../../../LICENSE-APACHE")),
    ("LICENSE-MIT.txt", include_str!("../../../LICENSE-MIT")),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// FMI-LS-WASM is a layered standard of FMI 3.0.
    #[test]
    fn components_are_of_fmi_3_only() {
        let of = |version| platform("wasm32-wasip2", version);
        assert_eq!((of(Version::V2), of(Version::V3)), (None, Some(("wasm32-wasip2", "wasm"))));
    }
}
