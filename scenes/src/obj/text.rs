//! Checks an OBJ text line by line and rewrites it so that tobj can neither panic nor guess.
//!
//! tobj's errors carry no line, it accepts `nan`, and it returns arrays of unequal length when some
//! faces have texture coordinates and others none. The text that leaves here has only finite
//! vertices, absolute indices that exist, a full `v/vt/vn` on each corner (with the stand-ins
//! below), triangles only, and `g0`, `m0`, ... in place of names.

use std::{collections::BTreeMap, fmt::Write, path::Path};

use glam::DVec3;

use crate::{
    error::{Location, SceneError},
    obj::polygon,
    warnings::Warnings,
};

/// The normal that stands in for a missing one on a corner without `vn`. A broken `vn` (zero or not finite) becomes
/// NaN, as does one that is missing where `s off` asks for flat faces.
pub(crate) const ABSENT_NORMAL: [f32; 3] = [0.0; 3];
/// Stand-ins at the front of the rewritten `vn` list: absent, broken.
const NORMAL_STAND_INS: usize = 2;
/// Stand-ins at the front of the rewritten `vt` list: none given.
const UV_STAND_INS: usize = 1;
const NO_UV: usize = 1;

/// A checked and rewritten OBJ.
#[derive(Debug, Default)]
pub(crate) struct CheckedObj {
    /// The text for tobj.
    pub text: String,
    /// `mtllib` statements: line and text.
    pub libraries: Vec<(usize, String)>,
    /// Object names in the order of their first face; `gN` in the text is index N.
    pub objects: Vec<String>,
    /// Material names in the order of their first face, each with that face's line; `mN` in the text is index N. Faces
    /// without `usemtl` have the empty name.
    pub uses: Vec<(String, usize)>,
    /// Of material N the line of its first face with a corner that has no texture coordinate.
    pub without_uv: BTreeMap<usize, usize>,
}

/// The current name, and its number once a face has used it.
struct CurrentName {
    text: String,
    number: Option<usize>,
}

impl CurrentName {
    fn new(text: &str) -> Self {
        Self { text: text.to_owned(), number: None }
    }

    /// The name's number; a name not met before gets the next one and is handed to `add`.
    fn resolve(&mut self, index: &mut BTreeMap<String, usize>, add: impl FnOnce(&str)) -> usize {
        *self.number.get_or_insert_with(|| {
            let next = index.len();
            *index.entry(self.text.clone()).or_insert_with(|| {
                add(&self.text);
                next
            })
        })
    }
}

/// The state of a pass over the lines.
struct ObjScan<'a> {
    path: &'a Path,
    warnings: &'a mut Warnings,
    out: CheckedObj,
    faces: String,
    positions: Vec<DVec3>,
    uvs: usize,
    /// Per `vn` whether it can be used.
    normals: Vec<bool>,
    /// Corners without a normal get one across edges, and not that of their face.
    smooth: bool,
    object: CurrentName,
    material: CurrentName,
    object_index: BTreeMap<String, usize>,
    use_index: BTreeMap<String, usize>,
    /// Object and material that the rewritten text selected last.
    selected: Option<(usize, usize)>,
}

/// Checks `text`, which came from `path`.
pub(crate) fn check(path: &Path, text: &str, warnings: &mut Warnings) -> Result<CheckedObj, SceneError> {
    let mut scan = ObjScan {
        path,
        warnings,
        out: CheckedObj::default(),
        faces: String::new(),
        positions: Vec::new(),
        uvs: 0,
        normals: Vec::new(),
        smooth: true,
        object: CurrentName::new("unnamed"),
        material: CurrentName::new(""),
        object_index: BTreeMap::new(),
        use_index: BTreeMap::new(),
        selected: None,
    };
    scan.out.text.push_str("mtllib m\nvt 0 0\nvn 0 0 0\nvn nan nan nan\n");
    // Faces may use vertices that come later, so vertices go first.
    let totals = scan.vertices(text)?;
    scan.faces(text, totals)?;
    if scan.faces.is_empty() {
        return Err(empty_mesh(path, "it has no face with three corners"));
    }
    scan.out.text.push_str(&scan.faces);
    Ok(scan.out)
}

/// A model without a single triangle.
pub(crate) fn empty_mesh(path: &Path, why: &str) -> SceneError {
    let what = format!("the mesh is empty: {why}");
    SceneError::input(Location::File(path.to_owned()), what, "a scene needs at least one triangle")
}

/// The statements with their line numbers; a backslash at the end continues a line.
fn statements(text: &str) -> impl Iterator<Item = (usize, String)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (index, first) = lines.next()?;
        let mut statement = first.trim_start_matches('\u{feff}').trim().to_owned();
        // Not in comments: `# C:\models\` ends in a path.
        let in_comment = |statement: &str| statement.split_whitespace().any(|word| word.starts_with('#'));
        while statement.ends_with('\\') && !in_comment(&statement) {
            statement.pop();
            let Some((_, more)) = lines.next() else { break };
            statement.push(' ');
            statement.push_str(more.trim());
        }
        Some((index + 1, statement))
    })
}

impl ObjScan<'_> {
    fn bad(&self, line: usize, what: String, fix: &str) -> SceneError {
        SceneError::input(Location::line(self.path, line), what, fix)
    }

    fn warn(&mut self, line: usize, key: &str, message: &str) {
        let path = self.path.display();
        self.warnings.add(key, || format!("{path}:{line}: {message}"));
    }

    /// First pass: every `v`, `vt` and `vn`. Returns how many of each there are.
    fn vertices(&mut self, text: &str) -> Result<[usize; 3], SceneError> {
        for (line, statement) in statements(text) {
            let mut words = statement.split_whitespace();
            let keyword = words.next().unwrap_or("");
            if !matches!(keyword, "v" | "vt" | "vn") {
                continue;
            }
            let mut numbers = [0.0_f32; 7];
            let mut count = 0;
            for word in words.take_while(|w| !w.starts_with('#')).take(7) {
                numbers[count] = word.parse().map_err(|_| {
                    self.bad(line, format!("`{keyword}` has `{word}` where a number is needed"), "correct the number")
                })?;
                count += 1;
            }
            match keyword {
                "v" => self.position(line, &statement, &numbers[..count])?,
                "vt" => self.uv(line, &numbers[..count])?,
                _ => self.normal(line, &numbers[..count])?,
            }
        }
        let totals = [self.positions.len(), self.uvs, self.normals.len()];
        // tobj and the mesh count vertices in 32 bits.
        if totals.iter().any(|t| *t > u32::MAX as usize / 4) {
            return Err(SceneError::Limit {
                at: Location::File(self.path.to_owned()),
                what: "cannot be read as OBJ: it has more than a billion vertices".into(),
                fix: "please report this file".into(),
            });
        }
        Ok(totals)
    }

    fn position(&mut self, line: usize, statement: &str, numbers: &[f32]) -> Result<(), SceneError> {
        let [x, y, z, more @ ..] = numbers else {
            return Err(self.bad(line, format!("`v` has {} numbers", numbers.len()), "a vertex needs three"));
        };
        if !(x.is_finite() && y.is_finite() && z.is_finite()) {
            let text: String = statement.chars().take(80).collect();
            let what = format!("vertex {} is not finite (`{text}`)", self.positions.len() + 1);
            return Err(self.bad(line, what, "correct the coordinate or export the model again"));
        }
        if matches!(more, [w] if *w != 1.0) {
            self.warn(line, "vertex weight", "the fourth number of a vertex is not read");
        }
        if more.len() >= 3 {
            self.warn(line, "vertex colour", "vertex colours are not supported and were ignored");
        }
        // Writing to a String cannot fail; `{}` is the shortest text that gives the same float again.
        let _ = writeln!(self.out.text, "v {x} {y} {z}");
        self.positions.push(DVec3::new(f64::from(*x), f64::from(*y), f64::from(*z)));
        Ok(())
    }

    fn uv(&mut self, line: usize, numbers: &[f32]) -> Result<(), SceneError> {
        let (mut u, mut v) = match numbers {
            [] => {
                return Err(self.bad(line, "`vt` has no number".into(), "a texture coordinate needs one to three"));
            }
            [u] => (*u, 0.0),
            [u, v, ..] => (*u, *v),
        };
        if !(u.is_finite() && v.is_finite()) {
            self.warn(line, "vt", "a texture coordinate is not finite and was set to 0 0");
            (u, v) = (0.0, 0.0);
        }
        let _ = writeln!(self.out.text, "vt {u} {v}");
        self.uvs += 1;
        Ok(())
    }

    fn normal(&mut self, line: usize, numbers: &[f32]) -> Result<(), SceneError> {
        let [x, y, z, ..] = numbers else {
            return Err(self.bad(line, format!("`vn` has {} numbers", numbers.len()), "a normal needs three"));
        };
        let length = DVec3::new(f64::from(*x), f64::from(*y), f64::from(*z)).length();
        let usable = length.is_finite() && length > 1e-12;
        if usable {
            let _ = writeln!(self.out.text, "vn {x} {y} {z}");
        } else {
            self.warn(line, "vn", "a normal is zero or not finite; its corners get the face's normal");
            self.out.text.push_str("vn 0 0 0\n");
        }
        self.normals.push(usable);
        Ok(())
    }

    /// Second pass: faces, names and the rest.
    fn faces(&mut self, text: &str, totals: [usize; 3]) -> Result<(), SceneError> {
        // Negative indices count back from what has been defined so far.
        let mut seen = [0_usize; 3];
        for (line, statement) in statements(text) {
            let (keyword, rest) = statement.split_once(char::is_whitespace).unwrap_or((&statement, ""));
            let rest = rest.trim();
            match keyword {
                "v" => seen[0] += 1,
                "vt" => seen[1] += 1,
                "vn" => seen[2] += 1,
                "f" | "fo" => self.face(line, rest, seen, totals)?,
                "o" | "g" => self.object = CurrentName::new(if rest.is_empty() { "unnamed" } else { rest }),
                "usemtl" if rest.is_empty() => {
                    self.warn(line, "usemtl without name", "`usemtl` without a name: its faces have no material");
                    self.material = CurrentName::new("");
                }
                "usemtl" => self.material = CurrentName::new(rest),
                "mtllib" => self.out.libraries.push((line, rest.to_owned())),
                "l" | "p" => self.warn(line, "lines", "points and lines have no surface and were ignored"),
                // Of smoothing groups only whether there is one counts: edges within it are told by the crease angle.
                "s" => self.smooth = !matches!(rest.split_whitespace().next(), Some("off" | "0")),
                // These only steer display.
                "" | "vp" | "lod" | "shadow_obj" | "trace_obj" | "c_interp" | "d_interp" | "bevel" => {}
                comment if comment.starts_with('#') => {}
                other => {
                    let what =
                        format!("`{}` is not supported and was ignored", other.chars().take(40).collect::<String>());
                    self.warn(line, &format!("obj {other}"), &what);
                }
            }
        }
        Ok(())
    }

    fn face(&mut self, line: usize, rest: &str, seen: [usize; 3], totals: [usize; 3]) -> Result<(), SceneError> {
        let mut corners = Vec::with_capacity(4);
        for word in rest.split_whitespace().take_while(|w| !w.starts_with('#')) {
            corners.push(self.corner(line, word, seen, totals)?);
        }
        if corners.len() < 3 {
            self.warn(line, "short face", "a face with fewer than three corners was ignored");
            return Ok(());
        }
        let material = self.select(line);
        if corners.iter().any(|corner| corner[1] == NO_UV) {
            self.out.without_uv.entry(material).or_insert(line);
        }
        let points: Vec<DVec3> = corners.iter().map(|c| self.positions[c[0] - 1]).collect();
        let (triangles, exact) = polygon::triangulate(&points);
        if !exact {
            self.warn(
                line,
                "polygon",
                "a concave polygon that is too large or crosses itself was cut as a fan and may look wrong",
            );
        }
        for triangle in triangles {
            self.faces.push('f');
            for [v, vt, vn] in triangle.map(|at| corners[at]) {
                let _ = write!(self.faces, " {v}/{vt}/{vn}");
            }
            self.faces.push('\n');
        }
        Ok(())
    }

    /// Resolves `v`, `v/vt`, `v//vn` or `v/vt/vn` to indices into the rewritten lists.
    fn corner(
        &mut self,
        line: usize,
        word: &str,
        seen: [usize; 3],
        totals: [usize; 3],
    ) -> Result<[usize; 3], SceneError> {
        const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];
        let mut found = [0_usize; 3];
        for (kind, part) in word.split('/').enumerate() {
            if part.is_empty() && kind > 0 {
                continue;
            }
            let index = match part.parse::<i64>() {
                Ok(index) if kind < 3 => index,
                _ => {
                    return Err(self.bad(
                        line,
                        format!("`{word}` is no face corner"),
                        "write v, v/vt, v//vn or v/vt/vn",
                    ));
                }
            };
            let absolute = if index < 0 { (seen[kind] as i64 + 1).saturating_add(index) } else { index };
            if absolute < 1 || absolute > totals[kind] as i64 {
                let (kind, count) = (KINDS[kind], totals[kind]);
                let what = format!("{kind} index {index} is out of range: the file has {count}");
                return Err(self.bad(line, what, "correct the face"));
            }
            found[kind] = absolute as usize;
        }
        let normal = match found[2] {
            0 if self.smooth => 1,
            0 => 2,
            n if self.normals[n - 1] => n + NORMAL_STAND_INS,
            _ => 2,
        };
        Ok([found[0], if found[1] == 0 { NO_UV } else { found[1] + UV_STAND_INS }, normal])
    }

    /// Writes `g` and `usemtl` when they changed. Names get their number at their first face, so
    /// empty groups are no objects. Returns the number of the material.
    fn select(&mut self, line: usize) -> usize {
        let objects = &mut self.out.objects;
        let object = self.object.resolve(&mut self.object_index, |name| objects.push(name.to_owned()));
        let uses = &mut self.out.uses;
        let material = self.material.resolve(&mut self.use_index, |name| uses.push((name.to_owned(), line)));
        if self.selected != Some((object, material)) {
            self.selected = Some((object, material));
            let _ = writeln!(self.faces, "g g{object}\nusemtl m{material}");
        }
        material
    }
}
