//! What values are made of: sums and ratios of the figures of runs.

use rayreel_machine::srp::KernelId;

use super::run::Run;

/// The sum of a figure over runs.
pub fn sum(runs: &[Run<'_>], of: impl Fn(&Run<'_>) -> Option<f64>) -> Option<f64> {
    runs.iter().map(of).sum()
}

/// The sum of a counter over runs.
pub fn count(runs: &[Run<'_>], name: &str) -> Option<f64> {
    sum(runs, |run| run.counter(name).map(|count| count as f64))
}

/// The sum of a figure by its name.
pub fn figure(runs: &[Run<'_>], name: &str) -> Option<f64> {
    sum(runs, |run| run.number(name))
}

/// The ratio of the sums of a figure of two lists of runs.
pub fn ratio(name: &str, over: &[Run<'_>], under: &[Run<'_>]) -> Option<f64> {
    Some(figure(over, name)? / figure(under, name)?)
}

/// The largest value of pairs of runs of a scene.
pub fn largest(a: &[Run<'_>], b: &[Run<'_>], of: impl Fn(&[Run<'_>], &[Run<'_>]) -> Option<f64>) -> Option<f64> {
    let each = (0..a.len().min(b.len())).map(|i| of(&a[i..=i], &b[i..=i]));
    each.reduce(|x, y| Some(x?.max(y?)))?
}

/// Mean of a figure over runs.
pub fn mean(runs: &[Run<'_>], name: &str) -> Option<f64> {
    Some(figure(runs, name)? / runs.len() as f64)
}

/// Bytes of nodes and triangles at the DRAM.
pub fn tree_bytes(runs: &[Run<'_>]) -> Option<f64> {
    Some(count(runs, "traffic/node_read")? + count(runs, "traffic/triangle_read")?)
}

/// All bytes at the DRAM.
pub fn dram_bytes(runs: &[Run<'_>]) -> Option<f64> {
    const REGIONS: [&str; 9] =
        ["node", "triangle", "attribute", "texture", "ray", "sample", "border", "gbuffer", "framebuffer"];
    let both = |region| {
        Some(count(runs, &format!("traffic/{region}_read"))? + count(runs, &format!("traffic/{region}_written"))?)
    };
    REGIONS.into_iter().map(both).sum()
}

/// Energy of the T&I units and of their lookups in the L2, nJ.
pub fn on_chip_nj(runs: &[Run<'_>]) -> Option<f64> {
    sum(runs, |run| {
        let one = std::slice::from_ref(run);
        let asked = count(one, "ti/trv/l1/misses")? + count(one, "ti/ist/l1/misses")?;
        let share = (asked / count(one, "l2/lookups")?).min(1.0);
        Some((run.number("energy_mj")? + run.energy_mj("l2")?.0 * share) * 1e6)
    })
}

/// Energy of everything but DRAM and PHY, nJ.
pub fn chip_nj(runs: &[Run<'_>]) -> Option<f64> {
    sum(runs, |run| {
        let of = |component| run.energy_mj(component).map(|(dynamic, leakage)| dynamic + leakage);
        Some((run.number("gpu_energy_mj")? - of("dram")? - of("dram_phy")?) * 1e6)
    })
}

/// Hits of the L1s of the T&I units over their lookups.
pub fn hit_rate(runs: &[Run<'_>]) -> Option<f64> {
    let both =
        |what: &str| Some(count(runs, &format!("ti/trv/l1/{what}"))? + count(runs, &format!("ti/ist/l1/{what}"))?);
    Some(both("hits")? / both("lookups")?)
}

/// Busy cycles of the SRPs: kernels and inspector.
pub fn srp_busy(runs: &[Run<'_>]) -> Option<f64> {
    let kernels = KernelId::ALL.map(KernelId::name);
    Some(in_kernels(runs, &kernels)? + count(runs, "srp/activity/inspector")?)
}

/// Cycles of the SRPs in some kernels.
pub fn in_kernels(runs: &[Run<'_>], kernels: &[&str]) -> Option<f64> {
    kernels.iter().map(|kernel| count(runs, &format!("srp/kernel/{kernel}/cycles"))).sum()
}

/// Cycles of the inspector for similarity tests: its share of all inspected items.
pub fn similarity_inspector(runs: &[Run<'_>]) -> Option<f64> {
    let items = |kernel: &str| count(runs, &format!("srp/kernel/{kernel}/items"));
    let (tests, all) = (items("similarity")?, items("similarity")? + items("shade")?);
    Some(count(runs, "srp/activity/inspector")? * tests / all)
}
