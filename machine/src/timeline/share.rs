//! How much of a step from look to look a unit was busy.

/// What was done between two looks, of what could be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// What was done, in the unit of `full`.
    pub part: u128,
    /// What fits.
    pub full: u128,
}

impl Share {
    /// In hundredths of a percent, rounded, so that it is the same everywhere.
    pub fn percent(&self) -> String {
        let hundredths = (self.part * 10_000 + self.full / 2).checked_div(self.full).unwrap_or(0);
        format!("{}.{:02}", hundredths / 100, hundredths % 100)
    }
}

/// Moves what does not fit into a step to those before it, or to those after it; what finds no room there goes the other way.
pub fn spread(steps: &mut [Share], before: bool) {
    for backwards in [before, !before] {
        if backwards { carry(steps.iter_mut().rev()) } else { carry(steps.iter_mut()) }
    }
}

/// Moves what does not fit into a step to those that come after it in `steps`; the last one keeps what is left.
fn carry<'a>(steps: impl Iterator<Item = &'a mut Share>) {
    let (mut over, mut last) = (0, None);
    for step in steps {
        let part = step.part + over;
        step.part = part.min(step.full);
        over = part - step.part;
        last = Some(step);
    }
    if let Some(last) = last {
        last.part += over;
    }
}
