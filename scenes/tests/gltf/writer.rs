//! A small writer of glTF, so that the reader is held against something else than itself.

use std::path::{Path, PathBuf};

use rayreel_scenes::{LoadOptions, Scene, SceneError};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::{folder, load_file};

/// A model under construction: JSON and one buffer.
#[derive(Clone, Debug)]
pub struct Writer {
    pub json: Value,
    pub bytes: Vec<u8>,
}

impl Writer {
    pub fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [],
            "accessors": [], "bufferViews": [], "buffers": []
        });
        Self { json, bytes: Vec::new() }
    }

    /// Appends to a list of the JSON and gives the index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("is a list");
        list.push(value);
        list.len() - 1
    }

    /// A node at the top of the scene.
    pub fn root(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("is a list").push(index.into());
        index
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// An accessor of 32-bit floats.
    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        let end = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..N).map(|i| values.iter().map(|v| v[i]).reduce(pick).unwrap_or(0.0)).collect()
        };
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5126, "count": values.len(), "type": kind,
                   "min": end(f32::min), "max": end(f32::max)}),
        )
    }

    /// An accessor of indices of the smallest type.
    pub fn indices(&mut self, values: &[u32]) -> usize {
        let most = values.iter().copied().max().unwrap_or(0);
        let (kind, size) = if most < 255 {
            (5121, 1)
        } else if most < 65_535 {
            (5123, 2)
        } else {
            (5125, 4)
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()[..size].to_vec()).collect();
        let view = self.view(&bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": kind, "count": values.len(), "type": "SCALAR"}),
        )
    }

    /// A mesh of one triangle list with flat normals.
    pub fn triangles(&mut self, positions: &[[f32; 3]], indices: &[u32]) -> usize {
        let (positions, indices) = (self.floats(positions), self.indices(indices));
        self.push("meshes", json!({"primitives": [{"attributes": {"POSITION": positions}, "indices": indices}]}))
    }

    fn text(&self, uri: Option<&str>) -> Vec<u8> {
        let mut json = self.json.clone();
        let mut buffer = json!({"byteLength": self.bytes.len()});
        if let Some(uri) = uri {
            buffer["uri"] = uri.into();
        }
        if json["buffers"].as_array().is_some_and(Vec::is_empty) {
            json["buffers"] = json!([buffer]);
        }
        // Empty lists are not valid glTF.
        let object = json.as_object_mut().expect("is an object");
        object.retain(|_, value| value.as_array().is_none_or(|list| !list.is_empty()));
        json.to_string().into_bytes()
    }

    /// The bytes of a `.glb`.
    pub fn glb(&self) -> Vec<u8> {
        let pad = |mut bytes: Vec<u8>, with: u8| {
            while !bytes.len().is_multiple_of(4) {
                bytes.push(with);
            }
            bytes
        };
        let (text, data) = (pad(self.text(None), b' '), pad(self.bytes.clone(), 0));
        let mut out = b"glTF".to_vec();
        let chunks = [(&text, b"JSON"), (&data, b"BIN\0")];
        let length = 12 + chunks.iter().map(|(bytes, _)| 8 + bytes.len()).sum::<usize>();
        out.extend([2_u32, length as u32].iter().flat_map(|n| n.to_le_bytes()));
        for (bytes, kind) in chunks {
            out.extend((bytes.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(bytes);
        }
        out
    }

    /// Writes NAME.glb.
    pub fn write_glb(&self, folder: &Path, name: &str) -> PathBuf {
        let path = folder.join(format!("{name}.glb"));
        std::fs::write(&path, self.glb()).expect("writes");
        path
    }

    /// Writes NAME.gltf with its buffer in `NAME data.bin`: the blank must be decoded.
    pub fn write_gltf(&self, folder: &Path, name: &str) -> PathBuf {
        std::fs::write(folder.join(format!("{name} data.bin")), &self.bytes).expect("writes");
        let path = folder.join(format!("{name}.gltf"));
        std::fs::write(&path, self.text(Some(&format!("{name}%20data.bin")))).expect("writes");
        path
    }

    /// Loads it as `a.glb`.
    pub fn try_load(&self, options: &LoadOptions) -> (TempDir, Result<Scene, SceneError>) {
        let folder = folder();
        let scene = load_file(&self.write_glb(folder.path(), "a"), options);
        (folder, scene)
    }

    #[track_caller]
    pub fn load(&self) -> (TempDir, Scene) {
        let (folder, scene) = self.try_load(&LoadOptions::default());
        (folder, scene.unwrap_or_else(|error| panic!("{error}")))
    }

    /// One triangle at a node, with a material.
    pub fn triangle(material: Value) -> Self {
        let mut writer = Self::new();
        let mesh = writer.triangles(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0, 1, 2]);
        if !material.is_null() {
            let material = writer.push("materials", material);
            writer.json["meshes"][mesh]["primitives"][0]["material"] = material.into();
        }
        writer.root(json!({"mesh": mesh, "name": "it"}));
        writer
    }
}
