//! Item queues of a tile slot: what waits for the array.

use std::collections::VecDeque;

use super::kernels::{KERNELS, KernelId};

/// Items of one branch of `shade`.
#[derive(Clone, Debug)]
struct Branch {
    material: u32,
    rays: VecDeque<u32>,
}

/// A queue of a slot: kernel, and for `shade` which of the branches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueueId {
    /// Kernel.
    pub kernel: KernelId,
    /// Index of the branch; 0 for other kernels.
    pub branch: usize,
}

/// The queues of a slot.
#[derive(Clone, Debug, Default)]
pub struct Queues {
    /// In order of material. Kept from tile to tile, so that nothing is allocated in the long run.
    shade: Vec<Branch>,
    shade_items: usize,
    rays: [VecDeque<u32>; 4],
    counts: [u32; KERNELS],
}

impl Queues {
    /// Adds a hit of the branch of `material`.
    #[inline]
    pub fn push_shade(&mut self, material: u32, ray: u32) {
        let branch = match self.shade.binary_search_by_key(&material, |b| b.material) {
            Ok(branch) => branch,
            Err(branch) => {
                self.shade.insert(branch, Branch { material, rays: VecDeque::new() });
                branch
            }
        };
        self.shade[branch].rays.push_back(ray);
        self.shade_items += 1;
    }

    /// Adds a ray to a kernel that works on rays, other than `shade`.
    #[inline]
    pub fn push_ray(&mut self, kernel: KernelId, ray: u32) {
        self.rays[kernel as usize].push_back(ray);
    }

    /// Adds items that are no rays.
    pub fn push_count(&mut self, kernel: KernelId, items: u32) {
        self.counts[kernel as usize] += items;
    }

    /// Calls `visit` with each queue that is not empty, by kernel, then by material.
    #[inline]
    pub fn each(&self, mut visit: impl FnMut(QueueId, usize)) {
        for kernel in KernelId::ALL {
            match kernel {
                KernelId::Shade => {
                    if self.shade_items > 0 {
                        for (branch, Branch { rays, .. }) in self.shade.iter().enumerate() {
                            if !rays.is_empty() {
                                visit(QueueId { kernel, branch }, rays.len());
                            }
                        }
                    }
                }
                KernelId::Raygen | KernelId::Miss | KernelId::ShadowResult => {
                    let items = self.rays[kernel as usize].len();
                    if items > 0 {
                        visit(QueueId { kernel, branch: 0 }, items);
                    }
                }
                _ => {
                    let items = self.counts[kernel as usize] as usize;
                    if items > 0 {
                        visit(QueueId { kernel, branch: 0 }, items);
                    }
                }
            }
        }
    }

    /// Items of all queues.
    pub fn items(&self) -> usize {
        self.shade_items + self.rays.iter().map(VecDeque::len).sum::<usize>() + self.counts.iter().sum::<u32>() as usize
    }

    /// Takes up to `most` items from the front of a queue; rays are put into `into`. Returns how many.
    pub fn take(&mut self, id: QueueId, most: usize, into: &mut Vec<u32>) -> usize {
        let queue = match id.kernel {
            KernelId::Shade => &mut self.shade[id.branch].rays,
            KernelId::Raygen | KernelId::Miss | KernelId::ShadowResult => &mut self.rays[id.kernel as usize],
            _ => {
                let count = &mut self.counts[id.kernel as usize];
                let items = most.min(*count as usize);
                *count -= items as u32;
                return items;
            }
        };
        let items = most.min(queue.len());
        into.extend(queue.drain(..items));
        if id.kernel == KernelId::Shade {
            self.shade_items -= items;
        }
        items
    }
}
