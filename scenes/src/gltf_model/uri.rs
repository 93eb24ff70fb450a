//! Data that a URI names: inside the URI, or in a file beside the model. Nothing else is opened.

use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use base64::{
    Engine,
    alphabet::STANDARD,
    engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig},
};

use crate::error::{Location, SceneError};

/// Exporters differ on whether `=` ends the data.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The bytes that `uri` in the file at `model` names; `what` is their kind, `at` where the URI stands.
pub(crate) fn read(model: &Path, at: &Location, what: &str, uri: &str, most: u64) -> Result<Vec<u8>, SceneError> {
    if let Some(data) = inside(uri) {
        return decode(at, what, data);
    }
    let file = local(model, at, what, uri)?;
    let missing = |source| SceneError::missing(at.clone(), what, &file, source);
    let length = std::fs::metadata(&file).map_err(missing)?.len();
    if length > most {
        let text = format!("the {what} `{}` has {length} bytes: at most {most} are read", file.display());
        return Err(SceneError::Limit { at: at.clone(), what: text, fix: "make it smaller".into() });
    }
    rayreel_settings::files::read(&file, most).map_err(missing)
}

/// The first bytes of what `uri` names, as far as they can be had.
pub(crate) fn head(model: &Path, uri: &str, most: usize) -> Option<Vec<u8>> {
    let Some(data) = inside(uri) else {
        let file = file(model, uri)?;
        rayreel_settings::files::check(&file, u64::MAX).ok()?;
        let mut bytes = Vec::new();
        File::open(file).ok()?.take(most as u64).read_to_end(&mut bytes).ok()?;
        return Some(bytes);
    };
    // Four characters of base64 are three bytes, and one byte may be written `%00`.
    let start = data.find(',')? + 1;
    let begin: String = data.chars().take(start + most.div_ceil(3) * 4 * 3).collect();
    let mut bytes = decode(&Location::File(model.to_owned()), "picture", &begin).ok()?;
    bytes.truncate(most);
    Some(bytes)
}

/// The MIME type that a data URI says its data has, in small letters; none of another URI.
pub(crate) fn mime_type(uri: &str) -> Option<String> {
    let head = inside(uri)?.split([';', ',']).next()?;
    Some(head.trim().to_lowercase())
}

/// What follows `data:`, where the data stands in the URI itself.
fn inside(uri: &str) -> Option<&str> {
    let (scheme, data) = uri.split_at_checked(5)?;
    scheme.eq_ignore_ascii_case("data:").then_some(data)
}

/// The file that a URI in the file at `model` names; nothing if its data stands in the URI, or it names none that would be read.
pub(crate) fn file(model: &Path, uri: &str) -> Option<PathBuf> {
    inside(uri).is_none().then(|| local(model, &Location::File(model.to_owned()), "file", uri).ok()).flatten()
}

fn decode(at: &Location, what: &str, data: &str) -> Result<Vec<u8>, SceneError> {
    let fail = |why: String| SceneError::input(at.clone(), why, "export the model again");
    let (head, body) = data.split_once(',').ok_or_else(|| fail(format!("the data URI of the {what} has no data")))?;
    if !head.to_ascii_lowercase().ends_with(";base64") {
        return Ok(percent_encoding::percent_decode_str(body).collect());
    }
    BASE64.decode(body.trim()).map_err(|error| fail(format!("the data URI of the {what} is no base64: {error}")))
}

/// The file of a relative URI, in the folder of the model or below it.
fn local(model: &Path, at: &Location, what: &str, uri: &str) -> Result<PathBuf, SceneError> {
    let refuse = |why: &str, fix: &str| {
        // Data that lost its `data:` can be long.
        let short: String = uri.chars().take(80).collect();
        Err(SceneError::input(at.clone(), format!("the {what} `{short}` {why}"), fix))
    };
    let name = percent_encoding::percent_decode_str(uri).decode_utf8_lossy().replace('\\', "/");
    // A colon that is written `%3A` is one of the name.
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme);
    if scheme.is_some_and(|s| !s.is_empty() && s.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))) {
        return refuse(
            "is not in a file beside the model, and nothing is fetched",
            "download it into the model's folder and name it by its file name",
        );
    }
    if name.is_empty() || name.contains('\0') {
        return refuse("names no file", "name one in the model's folder");
    }
    match within(Path::new(&name)) {
        Some(relative) => Ok(model.parent().unwrap_or(Path::new("")).join(relative)),
        None => refuse("leaves the model's folder, and only files in it are read", "put the file there"),
    }
}

/// A relative path without `.` and `..`, by its names alone: a folder in it may be a link to elsewhere. None if it leaves where it begins.
fn within(path: &Path) -> Option<PathBuf> {
    let mut inside = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(name) => inside.push(name),
            Component::CurDir => {}
            Component::ParentDir if inside.pop() => {}
            _ => return None,
        }
    }
    Some(inside)
}
