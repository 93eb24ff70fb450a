//! Everything that can be wrong with a scene, each with where it is and what to do about it.

use std::path::PathBuf;

/// Why a scene could not be loaded.
///
/// Messages are fragments: a caller puts them behind its own words (`cannot load scene: {err}`).
/// Each names the file, the line where one is known, what is wrong, and what would put it right.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A name that is neither a built-in scene nor a path to a scene file.
    #[error("no scene is called `{name}`; {hint}")]
    UnknownScene {
        /// What was asked for.
        name: String,
        /// Near names, or the list of all.
        hint: String,
    },
    /// A file that should be read is a folder.
    #[error("{}: is a folder; name the {expected} inside it", path.display())]
    IsFolder {
        /// The folder.
        path: PathBuf,
        /// What kind of file was wanted.
        expected: &'static str,
    },
    /// A file could not be read.
    #[error("{}: cannot read this {what}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What kind of file it is.
        what: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file that another file names does not exist or cannot be read.
    #[error("{}:{line}: the {what} `{}` cannot be read; put it there or remove the line", path.display(), missing.display())]
    MissingFile {
        /// The file that names it.
        path: PathBuf,
        /// The line that names it, from 1.
        line: usize,
        /// `material library` or `texture`.
        what: &'static str,
        /// The file that is not there.
        missing: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A texture exists but is no image that can be decoded.
    #[error("{}:{line}: the texture `{}` cannot be decoded: {reason}; PNG and JPEG up to {max} x {max} texels can", path.display(), texture.display(), max = crate::validate::MAX_TEXTURE_SIDE)]
    Texture {
        /// The file that names the texture.
        path: PathBuf,
        /// The line that names it, from 1.
        line: usize,
        /// The image file.
        texture: PathBuf,
        /// What the decoder says.
        reason: String,
    },
    /// A line of an OBJ, MTL or CSV file that cannot be understood.
    #[error("{}:{line}: {what}; {fix}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        what: String,
        /// What to write instead.
        fix: String,
    },
    /// A vertex coordinate is not a finite number.
    #[error("{}:{line}: vertex {vertex} is not finite (`{text}`); correct the coordinate or export the model again", path.display())]
    VertexNotFinite {
        /// The OBJ file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The vertex, counted from 1 as in OBJ.
        vertex: usize,
        /// The line's text.
        text: String,
    },
    /// A face refers to a vertex, texture coordinate or normal that does not exist.
    #[error("{}:{line}: {kind} index {index} is out of range: the file has {count}; correct the face", path.display())]
    IndexOutOfRange {
        /// The OBJ file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// `vertex`, `texture coordinate` or `normal`.
        kind: &'static str,
        /// The index as written.
        index: i64,
        /// How many there are.
        count: usize,
    },
    /// A model without a single triangle.
    #[error("{}: the mesh is empty: {why}; a scene needs at least one triangle", path.display())]
    EmptyMesh {
        /// The OBJ file.
        path: PathBuf,
        /// Why nothing is left.
        why: String,
    },
    /// A model that the OBJ reader refuses although every line passed the checks.
    #[error("{}: cannot be read as OBJ: {reason}; please report this file", path.display())]
    Obj {
        /// The OBJ file.
        path: PathBuf,
        /// What the reader says.
        reason: String,
    },
    /// The scene file is not valid TOML, or has an unknown key or a wrong type.
    #[error("{}:{line}:{column}: {message}", path.display())]
    Toml {
        /// The scene file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// What the parser says.
        message: String,
    },
    /// A value in the scene file that makes no sense.
    #[error("{}: {what}; {fix}", path.display())]
    Value {
        /// The scene file.
        path: PathBuf,
        /// What is wrong, with the key's name.
        what: String,
        /// What to write instead.
        fix: String,
    },
    /// `[materials.NAME]` names a material that the model does not have.
    #[error("{}:{line}: the model has no material `{name}`; {hint}", path.display())]
    UnknownMaterial {
        /// The scene file.
        path: PathBuf,
        /// The line of the table, from 1.
        line: usize,
        /// The name.
        name: String,
        /// Near names, or the list of all.
        hint: String,
    },
    /// A camera that cannot look.
    #[error("{place}: {what}; {fix}")]
    Camera {
        /// Scene or file, and frame.
        place: String,
        /// What is wrong.
        what: String,
        /// What to do.
        fix: &'static str,
    },
    /// More lights than the trace can hold.
    #[error("{place}: {count} lights are too many: at most {} fit the trace; remove some", crate::validate::MAX_LIGHTS)]
    TooManyLights {
        /// Scene or file.
        place: String,
        /// How many there are.
        count: usize,
    },
    /// A scene whose parts do not fit together.
    #[error("scene `{scene}` is not consistent: {what}")]
    Invalid {
        /// The scene's name.
        scene: String,
        /// What does not fit.
        what: String,
    },
}

/// At most three of `known` that look like `name`, best first.
pub(crate) fn near_names<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let wanted = name.to_lowercase();
    let budget = (wanted.chars().count() / 3).max(2);
    let mut near: Vec<(usize, &str)> = known
        .filter_map(|candidate| {
            let lower = candidate.to_lowercase();
            let contains =
                wanted.len() >= 3 && (lower.contains(&wanted) || (lower.len() >= 3 && wanted.contains(&lower)));
            let distance = if contains { 1 } else { edit_distance(&wanted, &lower) };
            (distance <= budget).then_some((distance, candidate))
        })
        .collect();
    near.sort();
    near.truncate(3);
    near.into_iter().map(|(_, candidate)| candidate).collect()
}

/// `did you mean ...?` when something is near, else the list of what there is.
pub(crate) fn hint<'a>(name: &str, known: &[&'a str], what: &str) -> String {
    let near = near_names(name, known.iter().copied());
    let quote = |names: &[&'a str]| names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    match (near.is_empty(), known.len()) {
        (false, _) => format!("did you mean {}?", quote(&near)),
        (true, 0) => format!("there are no {what}"),
        (true, 1..=12) => format!("the {what} are {}", quote(known)),
        (true, count) => format!("the {what} are {} and {} more", quote(&known[..12]), count - 12),
    }
}

/// Levenshtein distance, capped by giving up on long words: names are short.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().take(64).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
