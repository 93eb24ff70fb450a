//! A machine for unit tests, independent of the presets: round values, latencies that can be told apart.

use super::config::MachineConfig;

const TEXT: &str = r#"
[gpu]
cores = 1
tiles_in_flight = 2
interface = "direct"
interface_bytes_per_cycle = 32
ray_message_bytes = 32
hit_message_bytes = 16
geometry_buffer = "on_chip"
primary_visibility = "traced"
[ti]
clock_mhz = 500
trv = 1
ist = 1
pipeline = "parallel"
aabbs_per_cycle = 2
ray_fifo_entries = 16
rays_per_trv = 32
ist_entries = 32
miss_handling = "reorder"
accumulate_rows = 16
accumulate_rays_per_row = 8
setup_cycles = 17
inner_cycles = 10
leaf_cycles = 5
stack_cycles = 3
ist_cycles = 30
crossbar_cycles = 2
stack_entries = 8
trv_lines_per_cycle = 1
ist_lines_per_cycle = 1
trv_l1 = { size = "16KiB", ways = 4, mshrs = 16, latency_cycles = 1, replacement = "lru" }
ist_l1 = { size = "16KiB", ways = 4, mshrs = 16, latency_cycles = 1, replacement = "lru" }
[l2]
size = "256KiB"
ways = 8
banks = 4
queue_entries = 8
mshrs = 32
latency_cycles = 10
replacement = "lru"
inclusive = false
line_bytes = 64
[dram]
clock_mhz = 1600
channels = 4
banks = 8
row_bytes = 2048
burst_bytes = 32
tccd = 8
trcd = 29
trp = 29
trp_all = 34
tras = 68
trrd = 16
tfaw = 64
rl = 31
wl = 14
trtp = 12
twr = 29
twtr = 16
trfc = 448
trefi = 6246
read_queue_entries = 32
write_queue_entries = 32
write_high = 24
write_low = 8
controller_cycles = 56
sync_cycles = 2
[srp]
clock_mhz = 1000
ideal = false
divergence = "inspector"
inspector_cycles = 1
batch_min = 16
batch_max = 64
local_memory = "64KiB"
attribute_bytes = 64
textures = true
texel_bytes = 4
sample = { object = 4, normal = 4, position = 6, shadow = 1, colour = 4, flags = 1 }
l1 = { size = "16KiB", ways = 4, mshrs = 16, latency_cycles = 1, replacement = "lru" }
[srp.kernels]
raygen = { ii_cycles = 5, prologue_cycles = 20, ops = 40 }
shade = { ii_cycles = 22, prologue_cycles = 40, ops = 175 }
light = { ii_cycles = 8, prologue_cycles = 0, ops = 60 }
miss = { ii_cycles = 2, prologue_cycles = 20, ops = 16 }
update = { ii_cycles = 1, prologue_cycles = 20, ops = 8 }
similarity = { ii_cycles = 2, prologue_cycles = 20, ops = 12 }
interpolate = { ii_cycles = 2, prologue_cycles = 20, ops = 14 }
resolve = { ii_cycles = 1, prologue_cycles = 20, ops = 6 }
[layout]
node_bytes = 64
triangle_bytes = 64
pixel_bytes = 4
[raster]
samples_per_cycle = 1
gbuffer_bytes = 20
[energy]
box_test_pj = 15
triangle_test_pj = 42
ray_setup_pj = 27
bypass_pj = 10
ray_buffer_read_pj = 6.5
ray_buffer_write_pj = 8
stack_push_pj = 0.47
stack_pop_pj = 0.26
crossbar_pj = 2
trv_l1_read_pj = 5.7
ist_l1_read_pj = 5.7
srp_l1_read_pj = 5.7
l1_miss_pj = 1
l1_fill_pj = 8.6
accumulate_pj = 8
reorder_pj = 1
l2_read_pj = 21
l2_miss_pj = 5
l2_fill_pj = 50
interface_pj_per_byte = 0.5
srp_op_pj = 3.5
local_read_pj = 1.8
local_write_pj = 1.9
dram_row_pj = 1200
dram_read_pj = 2170
dram_write_pj = 1290
dram_refresh_pj = 22400
dram_phy_pj_per_byte = 28
dram_background_uw = 38000
sram_leakage_uw_per_kib = 20
trv_leakage_uw = 250
ist_leakage_uw = 500
srp_leakage_uw = 5000
clock_tree_percent = 20
"#;

/// The machine.
pub(crate) fn machine() -> MachineConfig {
    toml::from_str(TEXT).expect("the test machine is complete")
}
