//! Mutated OBJ, MTL and TOML text never panics, and what loads is valid.

use std::fs;

use proptest::prelude::*;
use rayreel_scenes::load;

const OBJ: &str = "mtllib a.mtl\no box\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nusemtl m\nf 1/1/1 2/2/1 3/3/1 4\ng top\nusemtl n\nf 1 2 5\nf -4 -3 -1\ns 1\nf 3//1 4 5\n";
const MTL: &str = "newmtl m\nKd 0.5 0.4 0.3\nKs 0.2\nNs 30\nillum 3\n\nnewmtl n\nKd 0.1 0.1 0.1\nTf 0.9 0.8 0.7\nNi 1.5\nd 0.5\nTr 0.5\nillum 7\nKe 0 0 0\n";
const TOML: &str = "model = \"a.obj\"\n[camera]\neye = [5.0, 3.2, 7.0]\ntarget = [0.0, 0.4, 0.0]\nvfov_deg = 36.0\n[[lights]]\nkind = \"point\"\nposition = [6.0, 10.0, 6.0]\n[sky]\ncolour = [0.5, 0.6, 0.75]\n[materials.m]\nreflect = 0.25\n";
/// Words that have hurt readers before.
const WORDS: [&str; 22] = [
    "nan",
    "-inf",
    "1e40",
    "0",
    "-1",
    "99999999999999999999",
    "4294967296",
    "\\",
    "/",
    "//",
    "1/2/3/4",
    "f",
    "v",
    "vn 0 0 0",
    "usemtl",
    "mtllib a.mtl b.mtl",
    "Kd 0.5",
    "Kd spectral f",
    "map_Kd -s 1 1 1 a.obj",
    "illum 4",
    "\u{feff}",
    "é",
];

/// One change: where (in thousandths of the text), what kind, which word.
type Change = (usize, u8, usize);

fn mutate(text: &str, changes: &[Change]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for (place, kind, word) in changes {
        let at = place * bytes.len() / 1000;
        let word = WORDS[word % WORDS.len()];
        match kind % 5 {
            0 => drop(bytes.splice(at..at, word.bytes())),
            1 => drop(bytes.splice(at..at, format!("\n{word}\n").bytes())),
            2 => bytes.truncate(at),
            3 => drop(bytes.splice(at..(at + 3).min(bytes.len()), format!(" {word} ").bytes())),
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 0x15;
                }
            }
        }
    }
    bytes
}

fn changes() -> impl Strategy<Value = Vec<Change>> {
    prop::collection::vec((0..1000_usize, any::<u8>(), any::<usize>()), 0..5)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_files_never_panic(obj in changes(), mtl in changes(), toml in changes()) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, bytes) in [("a.obj", mutate(OBJ, &obj)), ("a.mtl", mutate(MTL, &mtl)), ("s.toml", mutate(TOML, &toml))] {
            fs::write(folder.path().join(name), bytes).expect("writes");
        }
        for name in ["a.obj", "s.toml"] {
            if let Ok(scene) = load(folder.path().join(name).to_str().expect("UTF-8")) {
                prop_assert!(scene.validate().is_ok());
            }
        }
    }
}
