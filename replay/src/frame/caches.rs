//! What the caches of machines keep from frame to frame (`gpu.warm_caches`).

use rayreel_machine::config::MachineConfig;
use rayreel_machine::functional::CacheState;

/// The caches of machines at the end of the frame that each did last.
#[derive(Debug, Default)]
pub(crate) struct KeptCaches(Vec<Kept>);

#[derive(Debug)]
struct Kept {
    config: MachineConfig,
    frame: u32,
    caches: CacheState,
}

impl KeptCaches {
    /// What the caches of a machine hold when frame `frame` begins. Nothing if they are empty: it did not do the frame before.
    pub fn of(&self, config: &MachineConfig, frame: u32) -> Option<CacheState> {
        let kept = self.0.iter().find(|kept| kept.config == *config);
        kept.filter(|kept| kept.frame.checked_add(1) == Some(frame)).map(|kept| kept.caches.clone())
    }

    /// Keeps what they hold at the end of frame `frame`, if the machine is to keep it: `caches` is asked only then.
    pub fn keep(&mut self, config: &MachineConfig, frame: u32, caches: impl FnOnce() -> CacheState) {
        if config.gpu.warm_caches {
            self.0.retain(|kept| kept.config != *config);
            self.0.push(Kept { config: config.clone(), frame, caches: caches() });
        }
    }
}
