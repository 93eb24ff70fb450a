//! Performance per watt, scene by scene, as SVG that reads on a light and on a dark page.

use std::fmt::Write;

use crate::table::{Row, SCENES, mean};

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 44.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 258.0;

const STYLE: &str = "<style>text{font:13px system-ui,sans-serif;fill:#333}.small{font-size:11px;fill:#666}line{stroke:#ccc}\
    .one{stroke:#888;stroke-dasharray:4 3}.paper-ss{fill:#9ab}.multirate{fill:#2a78b8}\
    @media (prefers-color-scheme:dark){text{fill:#ddd}.small{fill:#aaa}line{stroke:#444}}</style>";

/// The chart.
pub fn svg(rows: &[Row]) -> String {
    let most = rows.iter().map(|row| row.gain[2]).fold(1.0, f64::max);
    let top = (most / 2.0).ceil() * 2.0;
    let y = |value: f64| BOTTOM - (BOTTOM - TOP) * value / top;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         role=\"img\" aria-label=\"Performance per watt over full sampling, by scene\">{STYLE}\n"
    );
    for tick in (0..=top as u32).step_by(2) {
        let at = y(f64::from(tick));
        let _ = writeln!(svg, "<line x1=\"{LEFT}\" x2=\"{WIDTH}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>");
        let _ = writeln!(
            svg,
            "<text class=\"small\" x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{tick}×</text>",
            LEFT - 6.0,
            at + 4.0
        );
    }
    let _ = writeln!(svg, "<line class=\"one\" x1=\"{LEFT}\" x2=\"{WIDTH}\" y1=\"{0:.1}\" y2=\"{0:.1}\"/>", y(1.0));
    let slot = (WIDTH - LEFT) / (SCENES.len() + 1) as f64;
    for (i, name) in SCENES.iter().chain(&["mean"]).enumerate() {
        let middle = LEFT + slot * (i as f64 + 0.5);
        let _ = writeln!(svg, "<text x=\"{middle:.1}\" y=\"{}\" text-anchor=\"middle\">{name}</text>", BOTTOM + 18.0);
        for (policy, offset) in [("paper-ss", -42.0), ("multirate", 2.0)] {
            let row = rows.iter().find(|row| row.scene == *name && row.policy == policy);
            let value = row.map_or_else(|| mean(rows, policy, |row| row.gain[2]), |row| row.gain[2]);
            let (x, at) = (middle + offset, y(value));
            let _ = writeln!(
                svg,
                "<rect class=\"{policy}\" x=\"{x:.1}\" y=\"{at:.1}\" width=\"40\" height=\"{:.1}\"/>\
                 <text class=\"small\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{value:.2}</text>",
                BOTTOM - at,
                x + 20.0,
                at - 4.0
            );
            if let Some(row) = row {
                let _ = writeln!(
                    svg,
                    "<text class=\"small\" x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{:.1}</text>",
                    x + 20.0,
                    BOTTOM + 34.0,
                    row.psnr_db
                );
            }
        }
    }
    let _ = writeln!(
        svg,
        "<text class=\"small\" x=\"{}\" y=\"{}\" text-anchor=\"end\">dB</text>",
        LEFT - 6.0,
        BOTTOM + 34.0
    );
    for (x, policy) in [(LEFT, "paper-ss"), (LEFT + 110.0, "multirate")] {
        let _ = writeln!(
            svg,
            "<rect class=\"{policy}\" x=\"{x}\" y=\"10\" width=\"14\" height=\"14\"/><text x=\"{}\" y=\"22\">{policy}</text>",
            x + 20.0
        );
    }
    let _ = writeln!(
        svg,
        "<text class=\"small\" x=\"{WIDTH}\" y=\"22\" text-anchor=\"end\">performance per watt of the T&amp;I units alone over full sampling</text>"
    );
    svg + "</svg>\n"
}
