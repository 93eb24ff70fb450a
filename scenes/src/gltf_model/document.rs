//! The JSON of a glTF file and its binary data: opened, limited, checked.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use gltf::{Document, json};
use json::validation::{Error as Fault, Validate};

use super::uri;
use crate::error::{Location, SceneError};

/// More bytes than a file or a buffer may have: a typing error in a length must not fill the memory.
const MAX_BYTES: u64 = 1 << 32;

/// Extensions that a file may require, beside those that the `gltf` crate reads: accessors of all component types are.
const ALSO_READ: [&str; 1] = ["KHR_mesh_quantization"];

/// Extensions that the `gltf` crate knows, but whose pictures are not read.
const NOT_READ: [&str; 2] = ["KHR_texture_basisu", "EXT_texture_webp"];

/// Extensions that pack meshes.
const PACKED: [&str; 3] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// An opened glTF file. All indices in its JSON are in range, but those of animation channels.
pub(crate) struct Source {
    pub path: PathBuf,
    pub document: Document,
    buffers: Vec<Vec<u8>>,
}

impl Source {
    /// Opens a `.gltf` or `.glb` file with its buffers.
    pub fn open(path: &Path) -> Result<Self, SceneError> {
        let failed = |source| SceneError::Io { path: path.to_owned(), what: "glTF file", source };
        check_size(path, std::fs::metadata(path).map_err(failed)?.len())?;
        let bytes = rayreel_settings::files::read(path, MAX_BYTES).map_err(failed)?;
        let (root, blob) = parse(path, &bytes)?;
        let buffers = load_buffers(path, &root, blob)?;
        Ok(Self { path: path.to_owned(), document: Document::from_json_without_validation(root), buffers })
    }

    /// The JSON.
    pub fn root(&self) -> &json::Root {
        self.document.as_json()
    }

    /// The model, and the files of buffers and pictures that it names.
    pub fn files(&self) -> Vec<PathBuf> {
        let buffers = self.root().buffers.iter().map(|buffer| &buffer.uri);
        let named = buffers.chain(self.root().images.iter().map(|image| &image.uri)).flatten();
        std::iter::once(self.path.clone()).chain(named.filter_map(|uri| uri::file(&self.path, uri))).collect()
    }

    /// Extensions of which a warning tells where they stand, at nodes, materials and pictures, or which only pack what is there unpacked.
    pub fn told(&self) -> BTreeSet<String> {
        let of_nodes = self.root().nodes.iter().filter_map(|node| node.extensions.as_ref());
        let of_materials = self.root().materials.iter().filter_map(|material| material.extensions.as_ref());
        let of_nodes = of_nodes.flat_map(|extensions| extensions.others.keys());
        let others = of_nodes.chain(of_materials.flat_map(|extensions| extensions.others.keys())).cloned();
        others.chain(NOT_READ.into_iter().chain(PACKED).map(str::to_owned)).collect()
    }

    /// A place in the file, such as `accessor 3`.
    pub fn at(&self, part: impl Into<String>) -> Location {
        Location::Part { path: self.path.clone(), part: part.into() }
    }

    /// Something wrong at a place in the file, and what to do.
    pub fn bad(&self, part: impl Into<String>, what: impl Into<String>, fix: &str) -> SceneError {
        SceneError::input(self.at(part), what, fix)
    }

    /// The bytes of a buffer view; `part` says who asks.
    pub fn view(&self, part: &str, index: usize) -> Result<&[u8], SceneError> {
        let broken = |what: String| self.bad(part, what, "export the model again");
        let view =
            self.root().buffer_views.get(index).ok_or_else(|| broken(format!("there is no buffer view {index}")))?;
        let buffer = view.buffer.value();
        let bytes = self.buffers.get(buffer).ok_or_else(|| broken(format!("buffer view {index} names no buffer")))?;
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let range = start.checked_add(view.byte_length.0).map(|end| start as usize..end as usize);
        range.and_then(|range| bytes.get(range)).ok_or_else(|| {
            broken(format!(
                "buffer view {index} takes {} bytes from byte {start} of buffer {buffer}, which has {}",
                view.byte_length.0,
                bytes.len()
            ))
        })
    }
}

fn check_size(path: &Path, bytes: u64) -> Result<(), SceneError> {
    if bytes <= MAX_BYTES {
        return Ok(());
    }
    let what = format!("{bytes} bytes are too many: at most {MAX_BYTES} are read");
    Err(SceneError::Limit { at: Location::File(path.to_owned()), what, fix: "split the model".into() })
}

/// The JSON, checked, and the binary chunk of a `.glb`.
fn parse(path: &Path, bytes: &[u8]) -> Result<(json::Root, Option<Vec<u8>>), SceneError> {
    let (text, blob) = if bytes.starts_with(b"glTF") {
        chunks(path, bytes)?
    } else {
        (bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).to_vec(), None)
    };
    let root = json::deserialize::from_slice(&text).or_else(|error| without_gaps(&text).ok_or(error));
    let mut root: json::Root = root.map_err(|error| {
        if let Some(version) = other_version(&text) {
            return old_version(path, &version);
        }
        let at = Location::Line { path: path.to_owned(), line: error.line(), column: Some(error.column()) };
        // The place is said by `at`.
        let message = error.to_string();
        let what = message.split(" at line ").next().unwrap_or_default();
        SceneError::input(at, format!("the JSON cannot be read: {what}"), "export the model again")
    })?;
    check_version(path, &root)?;
    check_extensions(path, &mut root)?;
    check_indices(path, &root)?;
    Ok((root, blob))
}

/// The JSON of a file that leaves out what the `gltf` crate demands and glTF does not: the nodes of a scene, and the node that an
/// animation channel moves, which is ignored then. Nothing if it leaves out neither, or more than that is amiss.
fn without_gaps(text: &[u8]) -> Option<json::Root> {
    let mut root: json::Value = json::deserialize::from_slice(text).ok()?;
    let given = root.clone();
    for scene in list(&mut root, "scenes").into_iter().flatten().filter_map(json::Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| json::Value::Array(Vec::new()));
    }
    for animation in list(&mut root, "animations").into_iter().flatten() {
        if let Some(channels) = list(animation, "channels") {
            channels.retain(|channel| channel.pointer("/target/node").is_some());
        }
    }
    if root == given { None } else { json::deserialize::from_value(root).ok() }
}

/// The version that a file says it has, if it is not 2: such a file has another structure.
fn other_version(text: &[u8]) -> Option<String> {
    let root: json::Value = json::deserialize::from_slice(text).ok()?;
    let Some(version) = root.pointer("/asset/version") else {
        // The oldest files do not say theirs, and have objects where later ones have lists.
        return root.get("meshes")?.is_object().then(|| "1.0".to_owned());
    };
    let version = version.as_str().map_or_else(|| version.to_string(), str::to_owned);
    (!version.starts_with("2.")).then_some(version)
}

/// The list at a key.
fn list<'a>(of: &'a mut json::Value, key: &str) -> Option<&'a mut Vec<json::Value>> {
    of.get_mut(key).and_then(json::Value::as_array_mut)
}

/// JSON and binary chunk of a `.glb`.
fn chunks(path: &Path, bytes: &[u8]) -> Result<(Vec<u8>, Option<Vec<u8>>), SceneError> {
    let bad = |what: String| SceneError::input(Location::File(path.to_owned()), what, "export or copy the file again");
    // The crate subtracts the header from this length without a look.
    let length = bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    if !length.is_some_and(|length| (20..=bytes.len()).contains(&length)) {
        let says = length.map_or_else(String::new, |length| format!(" and says that it has {length}"));
        return Err(bad(format!("the .glb is cut short: it has {} bytes{says}", bytes.len())));
    }
    let glb = gltf::Glb::from_slice(bytes).map_err(|error| match error {
        gltf::Error::Binary(gltf::binary::Error::Version(1)) => old_version(path, "1.0"),
        gltf::Error::Binary(error) => bad(format!("this .glb cannot be read: {error}")),
        other => bad(format!("this .glb cannot be read: {other}")),
    })?;
    Ok((glb.json.into_owned(), glb.bin.map(std::borrow::Cow::into_owned)))
}

fn old_version(path: &Path, version: &str) -> SceneError {
    let what = format!("this is glTF {version}, and 2.0 is read");
    SceneError::input(Location::File(path.to_owned()), what, "export it as glTF 2.0")
}

fn check_version(path: &Path, root: &json::Root) -> Result<(), SceneError> {
    let version = &root.asset.version;
    if !version.starts_with("2.") {
        return Err(old_version(path, version));
    }
    // A later 2.x can be read as 2.0, unless the file says that it cannot.
    match root.asset.min_version.as_deref() {
        None | Some("2.0") => Ok(()),
        Some(needed) => Err(old_version(path, needed)),
    }
}

/// Refuses a file that cannot be understood without an extension that is not read. What is only used is told later.
fn check_extensions(path: &Path, root: &mut json::Root) -> Result<(), SceneError> {
    root.extensions_required.retain(|name| !ALSO_READ.contains(&name.as_str()));
    // A file that leaves it out of what it requires has no data without it all the same.
    let packed = packed(root);
    let Some(name) = packed.or_else(|| root.extensions_required.iter().find(|name| !is_read(name)).cloned()) else {
        return Ok(());
    };
    let fix = match name.as_str() {
        packed if PACKED.contains(&packed) => "unpack it: `gltf-transform copy IN.glb OUT.glb`",
        "KHR_texture_basisu" | "EXT_texture_webp" => "convert its pictures to PNG",
        _ => "export it without, or convert it: `assimp export IN.glb OUT.obj`",
    };
    let verb = if root.extensions_required.contains(&name) { "requires" } else { "uses" };
    let what = format!("it {verb} the extension {name}, which is not read");
    Err(SceneError::input(Location::File(path.to_owned()), what, fix))
}

/// Whether an extension is read, here or by the `gltf` crate.
pub(crate) fn is_read(name: &str) -> bool {
    let known = json::extensions::ENABLED_EXTENSIONS.contains(&name) && !NOT_READ.contains(&name);
    known || ALSO_READ.contains(&name)
}

/// The extension in which a mesh or its data are packed, without which nothing is left of them.
fn packed(root: &json::Root) -> Option<String> {
    let extensions = |primitive: &json::mesh::Primitive| -> Vec<String> {
        let others = primitive.extensions.as_ref().map(|extensions| &extensions.others);
        let has_data = |index: &json::Index<json::Accessor>| {
            root.accessors.get(index.value()).is_none_or(|accessor| accessor.buffer_view.is_some())
        };
        let is_whole = primitive.attributes.values().all(has_data);
        others.into_iter().flat_map(|others| others.keys()).filter(|_| !is_whole).cloned().collect()
    };
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    // What is packed lies in another buffer; the view's own is of the size that it would have, and without bytes.
    let stays_packed = |view: &json::buffer::View| -> Vec<String> {
        let unpacked = view.buffer.value();
        let is_empty = root.buffers.get(unpacked).is_some_and(|buffer| buffer.uri.is_none());
        let is_elsewhere =
            |value: &json::Value| value["buffer"].as_u64().is_some_and(|buffer| buffer != unpacked as u64);
        let others = view.extensions.iter().flat_map(|extensions| &extensions.others);
        others.filter(|(_, value)| is_empty && is_elsewhere(value)).map(|(name, _)| name.clone()).collect()
    };
    let of_views = root.buffer_views.iter().flat_map(stays_packed);
    primitives.flat_map(extensions).chain(of_views).find(|name| PACKED.contains(&name.as_str()))
}

/// Checks every index. Without `min` and `max` of positions a file is read all the same: nothing here needs them.
fn check_indices(path: &Path, root: &json::Root) -> Result<(), SceneError> {
    let part = |part: String| Location::Part { path: path.to_owned(), part };
    // The crate looks an accessor of positions up before it has checked the index.
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if let Some(index) = primitive.attributes.values().find(|index| index.value() >= root.accessors.len()) {
                let what = format!("there is no accessor {}", index.value());
                return Err(SceneError::input(
                    part(format!("mesh {m}, primitive {p}")),
                    what,
                    "export the model again",
                ));
            }
        }
    }
    let mut first: Option<(String, Fault)> = None;
    root.validate(root, json::Path::new, &mut |place, fault| {
        let place = place();
        let text = place.as_str();
        let bounds = text.contains("POSITION") && (text.ends_with(".min") || text.ends_with(".max"));
        // Without a view an accessor is all zeros, whether anything is changed of it or not.
        let zeros = fault == Fault::Missing && text.starts_with("accessors[") && text.ends_with(".bufferView");
        if first.is_none() && !bounds && !zeros {
            first = Some((text.to_owned(), fault));
        }
    });
    let Some((place, fault)) = first else { return Ok(()) };
    let what = match fault {
        Fault::IndexOutOfBounds => "the index is out of range".to_owned(),
        Fault::Missing => "it is missing".to_owned(),
        Fault::Oversize => "the number is too large".to_owned(),
        other => format!("the value is not valid glTF ({other:?})"),
    };
    Err(SceneError::input(part(place), what, "export the model again"))
}

fn load_buffers(path: &Path, root: &json::Root, mut blob: Option<Vec<u8>>) -> Result<Vec<Vec<u8>>, SceneError> {
    let mut total = 0_u64;
    let mut buffers = Vec::with_capacity(root.buffers.len());
    for (index, buffer) in root.buffers.iter().enumerate() {
        let part = format!("buffer {index}");
        let at = Location::Part { path: path.to_owned(), part };
        let bytes = match &buffer.uri {
            Some(text) => uri::read(path, &at, "buffer", text, MAX_BYTES)?,
            None => blob.take().ok_or_else(|| {
                SceneError::input(at.clone(), "it has no URI, and there is no binary chunk", "export the model again")
            })?,
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            let what = format!("it has {} bytes of the {} that the file states", bytes.len(), buffer.byte_length.0);
            return Err(SceneError::input(at, what, "export or copy it again"));
        }
        total += bytes.len() as u64;
        check_size(path, total)?;
        buffers.push(bytes);
    }
    Ok(buffers)
}
