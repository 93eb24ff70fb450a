//! What stands in the cells of printed tables.

/// A value with so many digits behind the point.
pub fn or_dash(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_string(), |v| format!("{v:.digits$}"))
}

/// PSNR of pictures that were compared; of identical ones there is none.
pub fn psnr(db: Option<f64>) -> String {
    db.map_or("same".into(), |v| format!("{v:.2}"))
}

/// How far an estimate may be off, behind it.
pub fn plus_minus(part: f64) -> String {
    format!(" ±{:.1}%", 100.0 * part)
}
