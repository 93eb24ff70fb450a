//! What the experiment is made of.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayreel_machine::config::{MachineConfig, NamedMachine, Pipeline};
use rayreel_machine::srp::{Needs, missing_kernels};
use rayreel_replay::NamedPolicy;
use rayreel_replay::detail::{Detail, Share};
use rayreel_scenes::Scene;
use rayreel_study::StudyError;
use rayreel_study::sweep::folder::PLAN;
use rayreel_study::sweep::reused::RESULTS;

use crate::error::Result;
use crate::policies::{self, Contender};

/// Picture size by default, pixels.
pub const SIZE: (u32, u32) = (512, 256);

/// The paper's.
pub const SIZE_FULL: (u32, u32) = (2048, 1024);

/// How much is simulated cycle by cycle if nothing else is asked for, in millionths of the tiles: frames that are too small for a
/// sample are simulated whole.
const SHARE: u32 = 50_000;

/// How much is simulated cycle by cycle if nothing else is asked for.
pub fn detail() -> Detail {
    Share::from_millionths(SHARE).map_or(Detail::Full, Detail::Sampled)
}

/// Scenes, policies, machines and sizes of an experiment.
pub struct Setup {
    /// The scenes, each once.
    pub stages: Vec<Stage>,
    /// The policies, `full` first.
    pub policies: Vec<(&'static Contender, Arc<NamedPolicy>)>,
    /// The machines; none for pictures and rays only.
    pub machines: Option<Machines>,
    /// Picture size, pixels.
    pub size: (u32, u32),
    /// Whether everything is done, at any cost.
    pub full: bool,
    /// Whether every policy is simulated on every architecture too.
    pub systems: bool,
    /// How much is simulated cycle by cycle.
    pub detail: Detail,
    /// The command line that repeats it.
    pub command: String,
    /// Name and version of the program, as captures record it.
    pub tool: String,
}

/// A scene of the experiment.
pub struct Stage {
    /// The scene.
    pub scene: Scene,
    /// Its name as part of file names: a scene file may call it anything.
    pub name: String,
    /// Its [`Scene::content_hash`].
    pub content: [u8; 32],
}

/// The machine asked for, and the same with an SRP that takes no time.
pub struct Machines {
    /// What was asked for: a preset or a file.
    pub spec: String,
    /// The whole GPU.
    pub whole: Arc<NamedMachine>,
    /// The T&I units alone; nothing where processors do their work.
    pub alone: Option<Arc<NamedMachine>>,
}

/// Folders of an experiment.
#[derive(Clone, Debug)]
pub struct Folders {
    /// Traces and results.
    pub cache: PathBuf,
    /// Study and pictures.
    pub out: PathBuf,
    /// Where results are looked for beside the cache: folders of sweeps and other cache folders.
    pub reuse: Vec<PathBuf>,
}

impl Folders {
    /// Refuses a folder whose results are to be taken, if it can hold none. Nothing of it is read.
    ///
    /// # Errors
    /// Which one it is, and which folders will do.
    pub fn check(&self) -> Result<()> {
        let lacks = |folder: &Path, name: &str| !folder.join(name).exists();
        // The cache may be one that this run fills.
        let others = self.reuse.iter().filter(|folder| **folder != self.cache);
        match others.into_iter().find(|folder| lacks(folder, PLAN) && lacks(folder, RESULTS)) {
            None => Ok(()),
            Some(folder) => {
                let detail = format!(
                    "there is neither {PLAN} nor {RESULTS} in it; is this the folder of a sweep? It has to be one, or a cache folder of \
                     `rayreel paper`"
                );
                Err(StudyError::Input { at: folder.display().to_string(), detail }.into())
            }
        }
    }
}

impl Stage {
    /// A scene with its name.
    pub fn new(scene: Scene) -> Self {
        let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
        let name = scene.name.chars().map(plain).collect();
        Self { content: scene.content_hash(), scene, name }
    }
}

impl Machines {
    /// A preset or file; with `warm` its caches keep what they hold from frame to frame.
    ///
    /// # Errors
    /// There is none, or it is wrong.
    pub fn load(spec: &str, warm: bool) -> Result<Self> {
        let warm = warm.then_some("gpu.warm_caches=true");
        let load = |ideal: Option<&str>| {
            let overrides: Vec<String> = warm.into_iter().chain(ideal).map(str::to_owned).collect();
            NamedMachine::load(spec, &overrides).map(Arc::new)
        };
        let whole = load(None)?;
        let has_units = whole.config.ti.pipeline != Pipeline::Software;
        let alone = if has_units { Some(load(Some("srp.ideal=true"))?) } else { None };
        Ok(Self { spec: spec.into(), whole, alone })
    }

    /// What traverses: the T&I units alone, or the whole GPU where there are none.
    pub fn traversal(&self) -> &Arc<NamedMachine> {
        self.alone.as_ref().unwrap_or(&self.whole)
    }
}

/// The kernels that a machine lacks of those that every policy but `full` needs: all of them test for similarity and interpolate.
pub(crate) fn lacking(config: &MachineConfig) -> Vec<&'static str> {
    missing_kernels(config, &Needs { similarity: true, interpolate: true, look_back: false })
}

impl Setup {
    /// An experiment at the default size. A scene that is named twice is one.
    ///
    /// # Errors
    /// Two scenes whose files would have one name.
    pub fn new(scenes: impl IntoIterator<Item = Scene>, machines: Option<Machines>) -> Result<Self> {
        let mut stages: Vec<Stage> = Vec::new();
        for stage in scenes.into_iter().map(Stage::new) {
            match stages.iter().find(|known| known.name == stage.name) {
                None => stages.push(stage),
                Some(known) if known.content == stage.content => {}
                Some(_) => {
                    let name = &stage.name;
                    let detail = format!("two scenes are called {name}; give the file of one of them another name");
                    return Err(StudyError::Usage { detail }.into());
                }
            }
        }
        let policies = policies::load()?;
        let tool = rayreel_tracer::TOOL.to_owned();
        let (size, detail, command) = (SIZE, detail(), String::new());
        Ok(Self { stages, policies, machines, size, full: false, systems: false, detail, command, tool })
    }

    /// Refuses a machine that cannot run all policies of the experiment. It takes no trace to know that.
    ///
    /// # Errors
    /// Which policy needs what the machine does not have.
    pub fn check(&self) -> Result<()> {
        let Some(Machines { whole, .. }) = &self.machines else { return Ok(()) };
        let needing = self.policies.iter().find(|(_, named)| named.policy.kind() != "full");
        let missing = lacking(&whole.config);
        let Some((policy, _)) = needing.filter(|_| !missing.is_empty()) else { return Ok(()) };
        let (machine, kernels, policy) = (&whole.name, missing.join(" and "), policy.name);
        let detail = format!(
            "machine {machine} has no kernel {kernels}, which policy {policy} of the experiment needs; name another machine, or give it \
             one (srp.kernels.*.stages)"
        );
        Err(StudyError::Usage { detail }.into())
    }

    /// The picture size, or where that is more than `most` either way the largest one of its shape that is not, as near as whole
    /// pixels come to it.
    pub(crate) fn size_within(&self, most: (u32, u32)) -> (u32, u32) {
        let (width, height) = self.size;
        if width <= most.0 && height <= most.1 {
            return self.size;
        }
        let [w, h, most_w, most_h] = [width, height, most.0, most.1].map(u64::from);
        // The nearest whole number to `side * by / of`: no more than the limit of this side, since the other is further over its own.
        let scaled = |side: u64, by: u64, of: u64| ((2 * side * by + of) / (2 * of)).max(1) as u32;
        if w * most_h >= h * most_w { (most.0, scaled(h, most_w, w)) } else { (scaled(w, most_h, h), most.1) }
    }

    /// Whether a policy has rates that vary over the picture.
    pub(crate) fn has_rates(&self, policy: usize) -> bool {
        !matches!(self.policies[policy].1.policy.kind(), "full" | "adaptive")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each side had its own limit, and pictures of other shapes were squeezed.
    #[test]
    fn smaller_pictures_keep_their_shape() {
        let within = |size, most| Setup { size, ..Setup::new([], None).unwrap() }.size_within(most);
        let small = (128, 64);
        assert_eq!([within(SIZE, small), within(SIZE, (256, 128))], [small, (256, 128)]);
        assert_eq!(within(SIZE_FULL, (512, 256)), (512, 256));
        for size in [(64, 32), (128, 1), (1, 64), small] {
            assert_eq!(within(size, small), size, "no larger");
        }
        assert_eq!([within((200, 300), small), within((300, 100), small)], [(43, 64), (128, 43)]);
        // Just over one limit, and of any shape.
        assert_eq!([within((129, 64), small), within((128, 65), small)], [(128, 64), (126, 64)]);
        assert_eq!([within((100_000, 1), small), within((1, u32::MAX), small)], [(128, 1), (1, 64)]);
    }

    #[test]
    fn a_folder_without_results_is_refused_unread() {
        let place = tempfile::tempdir().unwrap();
        let folder = |name: &str| place.path().join(name);
        let check = |name: &str| {
            let (cache, out) = (folder("cache"), folder("out"));
            Folders { cache, out, reuse: vec![folder(name)] }.check()
        };
        std::fs::create_dir_all(folder("other-cache").join(RESULTS)).unwrap();
        std::fs::create_dir_all(folder("sweep")).unwrap();
        let said = check("sweep").unwrap_err().to_string();
        for part in ["sweep: there is neither plan.json", "folder of a sweep?", "cache folder of `rayreel paper`"] {
            assert!(said.contains(part), "{part} in {said}");
        }
        std::fs::write(folder("sweep").join(PLAN), "").unwrap();
        assert!(check("sweep").is_ok() && check("other-cache").is_ok() && check("nowhere").is_err());
        assert!(check("sweep/plan.json").is_err() && check("cache").is_ok(), "no folder, and one that this run fills");
        assert!(!folder("cache").exists() && !folder("out").exists());
    }

    /// One of them was dropped without a word.
    #[test]
    fn two_scenes_of_one_name_are_refused() {
        let [cornell, mut other] = ["cornell", "teapot"].map(|name| rayreel_scenes::load(name).unwrap());
        let twice = Setup::new([cornell.clone(), cornell.clone()], None).unwrap();
        assert_eq!(twice.stages.len(), 1, "the same scene twice is one");
        other.name = cornell.name.clone();
        let error = Setup::new([cornell, other], None).err().expect("they differ");
        assert!(error.to_string().contains("two scenes are called cornell"), "{error}");
    }
}
