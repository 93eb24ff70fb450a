//! A machine for unit tests: small and round, with latencies that can be told apart.

use super::config::{MachineConfig, NamedMachine};

const TEXT: &str = r#"
extends = "sgrt-ti2"
[gpu]
cores = 1
hit_message_bytes = 16
[ti]
trv = 1
ray_fifo_entries = 16
rays_per_trv = 32
miss_handling = "reorder"
ist_miss_handling = "reorder"
setup_cycles = 17
leaf_cycles = 5
stack_cycles = 3
ist_lines_per_cycle = 1
trv_l1.latency_cycles = 1
ist_l1.latency_cycles = 1
[l2]
mshrs = 32
[dram]
# The distances between command starts of the tests are round: RL 31, RD-WR 27, the rest as before JEDEC's was converted.
interleave_bytes = 64
hash = false
page_policy = "open"
rl = 31
twpre = 2
trp = 31
tras = 66
trtp = 10
twr = 26
twtr = 15
tfaw = 67
trfc = 450
trp_all = 36
power_down_after = 1000000000
[srp]
batch_min = 16
batch_max = 64
l1.latency_cycles = 1
[srp.kernels]
shade = { prologue_cycles = 40 }
light = { ii_cycles = 8, prologue_cycles = 0, ops = 60 }
miss = { prologue_cycles = 20 }
update = { prologue_cycles = 20 }
secondary = { ii_cycles = 1, ops = 10 }
similarity = { stages = 10 }
interpolate = { ops = 14, stages = 10 }
resolve = { prologue_cycles = 20, ops = 6 }
[srp.test_ops]
normal = 7
[layout]
triangle_bytes = 64
[raster]
samples_per_cycle = 1
gbuffer_bytes = 20
[energy]
bypass_stage_pj = 1
trv_clock_pj = 0
ist_clock_pj = 0
srp_clock_pj = 0
network_pj_per_byte = 0
crossbar_pj = 2
l1_miss_pj = 1
l1_fill_pj = 8.6
accumulate_pj = 8
reorder_pj = 1
l2_miss_pj = 5
l2_fill_pj = 50
interface_pj_per_byte = 0.5
trv_leakage_uw = 250
ist_leakage_uw = 500
srp_leakage_uw = 5000
"#;

/// The machine.
pub(crate) fn machine() -> MachineConfig {
    NamedMachine::parse("for tests", TEXT, &[]).expect("the test machine is complete").config
}
