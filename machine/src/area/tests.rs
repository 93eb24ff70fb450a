use super::AreaReport;
use crate::config::NamedMachine;

fn um2(machine: &str, overrides: &[&str]) -> Vec<(&'static str, u64)> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    let config = NamedMachine::load(machine, &overrides).unwrap().config;
    AreaReport::new(&config).components.iter().map(|c| (c.name, c.um2)).collect()
}

fn of(list: &[(&str, u64)], name: &str) -> u64 {
    list.iter().find(|(known, _)| *known == name).unwrap().1
}

/// An L1 of 16 KiB has 131072 bits of data and 256 x 24 of tags: 137216 x 0.064 / 0.6 um2 = 14636.37.
#[test]
fn sums_made_by_hand() {
    let found = um2("sgrt-ti2", &[]);
    let expected = [
        ("trv", 16 * (1_520 + 2 * 15_600)),
        // 16 units x 64 rays x 8 entries x 32 bits x 0.128 / 0.6.
        ("stacks", 55_924),
        ("ist", 4 * 36_700),
        ("trv_l1", 234_182),
        ("ist_l1", 58_545),
        // 4 cores x ((32 + 4 x 64 + 32 rays) x 512 bits + 16 rows x 512 bits) x 0.128 / 0.6.
        ("ray_buffers", 146_801),
        ("srp", 2_000_000),
        ("srp_l1", 58_545),
        // 4 x 64 KiB x 8 x 0.064 / 0.6.
        ("local_memory", 223_696),
        // 2097152 bits of data, 4096 x 24 of tags.
        ("l2", 234_182),
    ];
    assert_eq!(found, expected);
    let area = AreaReport::new(&NamedMachine::load("sgrt-ti2", &[]).unwrap().config);
    assert_eq!((area.ti_mm2(), area.gpu_mm2()), (1.165_772, 3.682_195));
    assert_eq!(area.components[0].mm2(), 0.523_520);
}

#[test]
fn units_differ_by_what_they_do() {
    let (ti2, ti1) = (um2("sgrt-ti2", &[]), um2("sgrt-ti1", &[]));
    assert_eq!(of(&ti1, "trv"), 2 * of(&ti2, "trv"), "half the gates of the single pipeline");
    let hybrid = um2("sgrt-hybrid-number", &[]);
    assert_eq!((of(&hybrid, "trv"), of(&hybrid, "ist")), (16 * (1_520 + 2 * 10_140), 4 * 30_830));
    let raycore = um2("raycore", &[]);
    assert_eq!(of(&raycore, "trv"), 6 * (1_520 + 2 * 15_600 + 36_700), "one pipeline does both");
    assert_eq!((of(&raycore, "ist"), of(&raycore, "ist_l1")), (0, 0));
    // 16 rows of a line in each of 16 units: 16 x 8192 bits x 0.128 / 0.6.
    let more = of(&um2("sgrt-ti2-accumulate", &[]), "ray_buffers") - of(&ti2, "ray_buffers");
    assert!((27_961..=27_963).contains(&more), "{more}");
    let full = um2("sgrt-ti2", &["ti.stack_entries=0"]);
    assert_eq!(of(&full, "stacks") / 8, of(&ti2, "stacks"), "a full stack has 64 entries");
    assert_eq!(of(&um2("sgrt-ti2", &["area.srp_um2=0"]), "srp"), 0);
}

/// The components are some of those of the energy, in its order.
#[test]
fn components_are_those_of_the_energy() {
    let config = NamedMachine::load("sgrt-ti2", &[]).unwrap().config;
    let energy = crate::EnergyReport::new(&config, &crate::Stats::default());
    let mut names = energy.components.iter().map(|c| (c.name, c.group));
    for component in AreaReport::new(&config).components {
        assert!(names.any(|known| known == (component.name, component.group)), "{}", component.name);
    }
}
