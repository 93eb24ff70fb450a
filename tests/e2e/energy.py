"""Recomputes the energy of a replay from its counters and constants, made from machine/MODEL.md alone.

usage: energy.py STATS.json ..., as `rayreel replay --json` prints it (every cycle, one machine)

Everything is exact: picojoules are multiples of 0.001, so all sums are whole femtojoules. Ends with code 1 where a component
differs by more than a femtojoule a frame.
"""

import json
import sys
from fractions import Fraction


def check(path):
    run = json.load(open(path))
    counter = {name: entry["value"] for name, entry in run["counters"].items()}
    constant = {name: entry["value"] for name, entry in run["machine_config"].items()}
    fj = lambda name: round(1000 * constant["energy." + name])  # pJ -> fJ
    n = lambda name: counter.get(name, 0)
    direct = constant["gpu.interface"] == "direct"
    cores, mhz = constant["gpu.cores"], constant["ti.clock_mhz"]
    trvs, ists = cores * constant["ti.trv"], cores * constant["ti.ist"]
    line = constant["l2.line_bytes"]

    def running(unit):
        classes = ["busy", "bypass", "fetch", "memory", "mshr", "blocked", "starved"]
        return sum(n(f"{unit}/{name}") for name in classes)

    # Prices are of a cache of one size; those of another are in proportion to CACTI's energies, by straight lines between them.
    cacti_reads = [(8, 8500), (16, 9500), (32, 11600), (64, 15600), (128, 23500), (256, 34300), (512, 62800)]
    cacti_fills = [(8, 12750), (16, 19238), (32, 29580), (64, 47970), (128, 84600), (256, 141488), (512, 292020)]
    whole = lambda value: int(value + Fraction(1, 2))

    def cacti(table, size):
        right = next((i for i, (kib, _) in enumerate(table) if kib * 1024 >= size), len(table) - 1) or 1
        (x0, y0), (x1, y1) = table[right - 1], table[right]
        distance = whole(abs(Fraction(size, 1024) - x0) * (y1 - y0) / (x1 - x0))
        return y0 + distance if size >= x0 * 1024 else y0 - distance

    def cache(unit, prices, of, size, late=0):
        priced = constant[f"energy.{of}_priced_size"]
        longer = Fraction(line, constant["energy.priced_line_bytes"])
        read, fill = (lambda s: cacti(cacti_reads, s)), (lambda s: max(cacti(cacti_fills, s), cacti(cacti_reads, s)))
        scaled = lambda name, table, lines: whole(fj(name) * lines * Fraction(table(size), table(priced)))
        tags = n(f"{unit}/misses") + n(f"{unit}/merges")
        return (
            (n(f"{unit}/hits") + late) * scaled(prices, read, longer)
            + tags * scaled(f"{of}_miss_pj", read, 1)
            + n(f"{unit}/fills") * scaled(f"{of}_fill_pj", fill, longer)
        )

    # Stacks and local memories: words of 32 bits.
    sizes = [512 << bits for bits in range(10)]
    ram_reads = list(zip(sizes, [200, 293, 430, 800, 1122, 1575, 2210, 3100, 4349, 6100]))
    ram_writes = list(zip(sizes, [430, 579, 780, 900, 1236, 1697, 2330, 3200, 4525, 6400]))

    def ram(price, table, priced, size):
        energy = lambda s: cacti([(Fraction(b, 1024), e) for b, e in table], s)
        return whole(fj(price) * Fraction(energy(size), energy(constant[f"energy.{priced}_priced_size"])))

    def l1(unit, read, size, late=0):
        return cache(unit, read, "l1", constant[size], late)

    def scaled(price, part):
        sizes = {"row": "dram.row_bytes", "burst": "dram.burst_bytes"}
        return whole(fj(price) * Fraction(constant[sizes[part]], constant[f"energy.dram_priced_{part}_bytes"]))

    # A longer word of a local memory costs what its bytes cost.
    longer_word = Fraction(constant["srp.local_word_bytes"], constant["energy.local_priced_word_bytes"])

    def local(price, table):
        return whole(ram(price, table, "local", constant["srp.local_memory"]) * longer_word)

    # Clock and leakage of a traversal unit follow the area of its tests.
    triangles = 1 if constant["ti.pipeline"] == "unified" else 0
    logic = lambda boxes, triangles: (
        constant["area.trv_control_um2"] + boxes * constant["area.box_um2"] + triangles * constant["area.triangle_um2"]
    )
    wider = Fraction(
        logic(constant["ti.aabbs_per_cycle"], triangles),
        logic(constant["energy.trv_priced_boxes"], constant["energy.trv_priced_triangles"]),
    )

    # A bypass passes the whole pipeline of its unit.
    depth = {"parallel": ["inner"], "single": ["inner", "leaf", "stack"], "unified": ["inner", "leaf", "stack", "ist"]}
    pipeline = constant["ti.pipeline"]
    stages = sum(constant[f"ti.{name}_cycles"] for name in depth[pipeline])
    first = "inner" if pipeline == "parallel" else "pipe"
    known = {name.split("/")[2] for name in counter if name.startswith("ti/trv/") and name.endswith("/busy")}
    first = first if first in known else sorted(known)[0]
    rays = n("ti/dispatch/rays")
    records = [n(f"ti/{unit}/buffer/{what}") for unit in ("trv", "ist") for what in ("record_writes", "record_reads", "parked", "slot_updates")]
    writes, reads, parked, updates = (records[i] + records[i + 4] for i in range(4))
    rows = lambda mode: constant["ti.accumulate_rows"] * line if constant[mode] == "accumulate" else 0
    stack = (constant["ti.stack_entries"] or constant["ti.full_stack_entries"]) * constant["ti.stack_entry_bytes"] * constant["ti.rays_per_trv"]
    record = constant["ti.ray_record_bytes"]
    buffers = (
        cores * constant["ti.ray_fifo_entries"] * record
        + trvs * (constant["ti.rays_per_trv"] * record + rows("ti.miss_handling"))
        + ists * (constant["ti.ist_entries"] * record + rows("ti.ist_miss_handling"))
    )
    ops = sum(value for name, value in counter.items() if name.startswith("srp/kernel/") and name.endswith("/ops"))
    array = sum(value for name, value in counter.items() if name.startswith("srp/activity/")) - n("srp/activity/idle")
    link = n("srp/interface/ray_bytes") + n("srp/interface/hit_bytes") if direct else 0
    bursts = (n("dram/reads") + n("dram/writes")) * constant["dram.burst_bytes"]
    tree = Fraction(100 + constant["energy.clock_tree_percent"], 100)
    # name: events in fJ, factor for the clock tree, microwatts of logic, bytes of memory
    parts = {
        "trv": (
            n("ti/trv/box_tests") * fj("box_test_pj")
            + n("ti/trv/triangle_tests") * fj("triangle_test_pj")
            + n("ti/trv/bypasses") * stages * fj("bypass_stage_pj")
            + rays * fj("ray_setup_pj")
            + running("ti/trv/" + first) * whole(fj("trv_clock_pj") * wider),
            1, trvs * whole(constant["energy.trv_leakage_uw"] * wider), 0),
        "stacks": (n("ti/trv/pushes") * ram("stack_push_pj", ram_writes, "stack", stack)
            + n("ti/trv/stack_operations") * ram("stack_pop_pj", ram_reads, "stack", stack), tree, 0, trvs * stack),
        "ist": (
            n("ti/ist/triangle_tests") * fj("triangle_test_pj")
            + n("ti/ist/bypasses") * constant["ti.ist_cycles"] * fj("bypass_stage_pj")
            + running("ti/ist/test") * fj("ist_clock_pj"),
            1, ists * constant["energy.ist_leakage_uw"], 0),
        "trv_l1": (l1("ti/trv/l1", "trv_l1_read_pj", "ti.trv_l1.size", n("ti/trv/buffer/late_reads")), tree, 0, trvs * constant["ti.trv_l1.size"]),
        "ist_l1": (l1("ti/ist/l1", "ist_l1_read_pj", "ti.ist_l1.size", n("ti/ist/buffer/late_reads")), tree, 0, ists * constant["ti.ist_l1.size"]),
        "ray_buffers": (
            (rays + writes) * fj("ray_buffer_write_pj") + (rays + reads) * fj("ray_buffer_read_pj")
            + parked * fj("accumulate_pj") + updates * fj("reorder_pj"),
            tree, 0, buffers),
        "crossbar": (2 * n("ti/ist/tasks") * fj("crossbar_pj"), tree, 0, 0),
        "srp": (ops * fj("srp_op_pj") + array * fj("srp_clock_pj"), 1, cores * constant["energy.srp_leakage_uw"], 0),
        "srp_l1": (l1("srp/l1", "srp_l1_read_pj", "srp.l1.size"), tree, 0, cores * constant["srp.l1.size"]),
        "local_memory": (
            n("srp/local/reads") * local("local_read_pj", ram_reads)
            + n("srp/local/writes") * local("local_write_pj", ram_writes),
            tree, 0, cores * constant["srp.local_memory"]),
        "interface": (link * fj("interface_pj_per_byte"), tree, 0, 0),
        "l2": (
            cache("l2", "l2_read_pj", "l2", constant["l2.size"]), tree, 0, constant["l2.size"]),
        "network": (n("l2/lookups") * (constant["l2.request_bytes"] + line) * fj("network_pj_per_byte"), tree, 0, 0),
        "dram": (
            n("dram/activates") * scaled("dram_row_pj", "row") + n("dram/reads") * scaled("dram_read_pj", "burst")
            + n("dram/writes") * scaled("dram_write_pj", "burst") + n("dram/refreshes") * fj("dram_refresh_pj"),
            1, constant["dram.channels"] * constant["energy.dram_background_uw"], 0),
        "dram_phy": (bursts * fj("dram_phy_pj_per_byte"), 1, 0, 0),
    }
    saved = constant["energy.dram_background_uw"] - constant["energy.dram_power_down_uw"]
    frames, wrong = len(run["frames"]), []
    for component in run["energy"]:
        events, factor, microwatts, size = parts.pop(component["name"])
        dynamic = events * factor
        power = microwatts + Fraction(constant["energy.sram_leakage_uw_per_kib"] * size, 1024)
        leakage = power * run["cycles"] * 1000 / mhz
        if component["name"] == "dram":
            leakage -= Fraction(saved * n("dram/powered_down") * 1000, constant["dram.clock_mhz"])
        for kind, mine in (("dynamic", dynamic), ("leakage", leakage)):
            theirs = component[kind + "_mj"] * 1e12
            # Each frame is rounded once; the JSON has doubles.
            if abs(theirs - float(mine)) > 2 * frames + 1e-12 * float(mine):
                wrong.append(f"{path}: {component['name']} {kind}: {theirs} fJ, recomputed {float(mine)}")
    wrong += [f"{path}: no component {name}" for name in parts]
    return wrong


def main():
    wrong = [line for path in sys.argv[1:] for line in check(path)]
    print("\n".join(wrong) or f"{len(sys.argv) - 1} runs: energy is what the counters say")
    sys.exit(bool(wrong))


main()
