//! One line of a material library: numbers with their checks, and texture statements with their
//! options.

use std::path::{Path, PathBuf};

use glam::Vec3;

use crate::{
    error::{Location, SceneError},
    warnings::Warnings,
};

/// A statement with where it stands.
#[derive(Debug)]
pub(crate) struct MtlLine<'a> {
    /// The library.
    pub path: &'a Path,
    /// MtlLine number from 1.
    pub number: usize,
    /// First word.
    pub keyword: &'a str,
    /// Everything behind it, trimmed.
    pub rest: &'a str,
}

impl<'a> MtlLine<'a> {
    /// Splits a line; `None` for an empty line or a comment.
    pub fn new(path: &'a Path, number: usize, raw: &'a str) -> Option<Self> {
        let text = raw.trim_start_matches('\u{feff}').trim();
        if text.is_empty() || text.starts_with('#') {
            return None;
        }
        let (keyword, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        Some(Self { path, number, keyword, rest: rest.trim() })
    }

    /// An error at this line.
    pub fn bad(&self, what: String, fix: impl Into<String>) -> SceneError {
        SceneError::input(Location::line(self.path, self.number), what, fix)
    }

    /// The words before a comment.
    fn words(&self) -> impl Iterator<Item = &'a str> {
        self.rest.split('#').next().unwrap_or("").split_whitespace()
    }

    fn float(&self, word: &str) -> Result<f32, SceneError> {
        match word.parse::<f32>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self
                .bad(format!("`{}` has `{word}` where a finite number is needed", self.keyword), "correct the number")),
        }
    }

    /// One number within bounds.
    pub fn number_in(&self, low: f32, high: f32) -> Result<f32, SceneError> {
        let Some(word) = self.words().next() else {
            return Err(self.bad(format!("`{}` without a number", self.keyword), "add the number or remove the line"));
        };
        let value = self.float(word)?;
        if value < low || value > high {
            let bounds = if high < f32::MAX { format!("between {low} and {high}") } else { format!("at least {low}") };
            return Err(self.bad(format!("`{}` is {value}", self.keyword), format!("it must be {bounds}")));
        }
        Ok(value)
    }

    /// `d 0.5` or `d -halo 0.5`.
    pub fn dissolve(&self, warnings: &mut Warnings) -> Result<f32, SceneError> {
        match self.rest.strip_prefix("-halo") {
            Some(rest) => {
                let (file, number) = (self.path.display(), self.number);
                warnings.add("halo", || format!("{file}:{number}: `-halo` is not supported; a constant `d` is used"));
                MtlLine { rest: rest.trim(), ..*self }.number_in(0.0, 1.0)
            }
            None => self.number_in(0.0, 1.0),
        }
    }

    /// The illumination model.
    pub fn illum(&self) -> Result<i64, SceneError> {
        let word = self.words().next().unwrap_or("");
        match word.parse::<i64>() {
            Ok(model @ 0..=10) => Ok(model),
            _ => {
                Err(self.bad(format!("`illum {word}` is no illumination model"), "it must be an integer from 0 to 10"))
            }
        }
    }

    /// A colour: one number (grey), three numbers, or `xyz` with one or three; `spectral` files are
    /// not supported (`None`, a warning).
    pub fn colour(&self, warnings: &mut Warnings) -> Result<Option<Vec3>, SceneError> {
        let words: Vec<&str> = self.words().collect();
        let (numbers, xyz) = match words.first() {
            Some(&"spectral") => {
                let (file, number, keyword) = (self.path.display(), self.number, self.keyword);
                warnings.add("spectral", || {
                    format!("{file}:{number}: `{keyword} spectral` is not supported; the default colour is used")
                });
                return Ok(None);
            }
            Some(&"xyz") => (&words[1..], true),
            _ => (&words[..], false),
        };
        let colour = match numbers {
            [grey] => Vec3::splat(self.float(grey)?),
            [r, g, b, ..] => Vec3::new(self.float(r)?, self.float(g)?, self.float(b)?),
            _ => {
                return Err(self.bad(format!("`{}` has {} numbers", self.keyword, numbers.len()), "write one or three"));
            }
        };
        let colour = if xyz { xyz_to_rgb(colour) } else { colour };
        if colour.min_element() < 0.0 {
            return Err(self.bad(format!("`{}` is negative", self.keyword), "colours start at 0"));
        }
        Ok(Some(colour))
    }
}

/// The file that the end of a statement names, beside the file that the statement is in.
fn file_named(beside: &Path, text: &str) -> PathBuf {
    let file = |name: &str| beside.parent().unwrap_or(Path::new("")).join(name.replace('\\', "/"));
    let whole = file(text);
    if whole.is_file() { whole } else { file(before_comment(text)) }
}

/// The end of a statement without a comment behind it, which stands behind a blank.
pub(crate) fn before_comment(text: &str) -> &str {
    let end = text.match_indices('#').find(|(at, _)| text[..*at].ends_with(char::is_whitespace));
    end.map_or(text, |(at, _)| text[..at].trim_end())
}

/// CIE XYZ to linear sRGB; colours outside the gamut are clipped at zero.
fn xyz_to_rgb(c: Vec3) -> Vec3 {
    let r = 3.240_97 * c.x - 1.537_383_2 * c.y - 0.498_610_76 * c.z;
    let g = -0.969_243_65 * c.x + 1.875_967_5 * c.y + 0.041_555_06 * c.z;
    let b = 0.055_630_08 * c.x - 0.203_976_96 * c.y + 1.056_971_5 * c.z;
    Vec3::new(r, g, b).max(Vec3::ZERO)
}

/// What a texture statement says.
#[derive(Debug)]
pub(crate) struct Map {
    /// The file, relative to the library's folder.
    pub file: PathBuf,
    /// The statement's line.
    pub line: usize,
    /// `-imfchan l` asks for the luminance.
    pub luminance: bool,
}

/// Reads a texture statement: its options, and the file behind them.
pub(crate) fn map(line: &MtlLine<'_>, warnings: &mut Warnings) -> Result<Map, SceneError> {
    let (mut rest, mut luminance) = (line.rest, false);
    while let Some((option, behind)) = next_option(rest) {
        let (arguments, after) = take_arguments(option, behind);
        if option == "-imfchan" {
            luminance = arguments == ["l"];
        }
        if !harmless(line.keyword, option, &arguments) {
            let (file, number) = (line.path.display(), line.number);
            warnings.add(&format!("map {option}"), || {
                format!(
                    "{file}:{number}: texture option `{option} {}` is not supported and was ignored",
                    arguments.join(" ")
                )
            });
        }
        rest = after;
    }
    if rest.is_empty() {
        return Err(line.bad(format!("`{}` names no file", line.keyword), "add the file name or remove the line"));
    }
    Ok(Map { file: file_named(line.path, rest), line: line.number, luminance })
}

/// The option at the front, when the front is one, and what follows it.
fn next_option(rest: &str) -> Option<(&str, &str)> {
    let (word, behind) = rest.split_once(char::is_whitespace)?;
    let known = [
        "-blendu", "-blendv", "-boost", "-bm", "-cc", "-clamp", "-imfchan", "-mm", "-o", "-s", "-t", "-texres", "-type",
    ];
    known.contains(&word).then_some((word, behind.trim_start()))
}

/// Arguments of an option. `-o`, `-s`, `-t` have one to three numbers; the last word always stays:
/// it is the file.
fn take_arguments<'a>(option: &str, mut rest: &'a str) -> (Vec<&'a str>, &'a str) {
    let (most, numeric) = match option {
        "-o" | "-s" | "-t" => (3, true),
        "-mm" => (2, true),
        _ => (1, false),
    };
    let mut arguments = Vec::new();
    while arguments.len() < most {
        let Some((word, behind)) = rest.split_once(char::is_whitespace) else {
            break;
        };
        if numeric && word.parse::<f32>().is_err() {
            break;
        }
        arguments.push(word);
        rest = behind.trim_start();
    }
    (arguments, rest)
}

/// Whether an option with these arguments changes nothing of what the statement means here.
fn harmless(keyword: &str, option: &str, arguments: &[&str]) -> bool {
    let all = |value: f32| arguments.iter().all(|a| a.parse::<f32>().is_ok_and(|n| (n - value).abs() < 1e-6));
    match option {
        "-s" => all(1.0),
        "-o" | "-t" => all(0.0),
        "-clamp" | "-cc" => arguments == ["off"],
        // A cut-out has one channel: that of luminance or of alpha.
        "-imfchan" => keyword != "map_d" || matches!(arguments, ["l" | "m"]),
        "-blendu" | "-blendv" | "-texres" => true,
        "-mm" => {
            matches!(arguments, [base, gain] if base.parse() == Ok(0.0_f32) && gain.parse() == Ok(1.0_f32))
        }
        _ => false,
    }
}
