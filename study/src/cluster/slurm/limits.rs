//! What a site allows.

/// Limits of the controller. An array above them is refused outright, so they are asked for before anything is submitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// `MaxArraySize`: task indices of one array are below it.
    pub array_size: usize,
    /// `MaxJobCount`: jobs that the controller keeps; each task of an array is one.
    pub job_count: usize,
}

impl Default for Limits {
    /// Slurm's own defaults.
    fn default() -> Self {
        Self { array_size: 1001, job_count: 10_000 }
    }
}

impl Limits {
    /// The limits in what `scontrol show config` prints; Slurm's defaults for what is not there.
    pub fn parse(config: &str) -> Self {
        let number = |name: &str| {
            let lines = config.lines().filter_map(|line| line.split_once('='));
            let mut values = lines.filter(|(key, _)| key.trim() == name).map(|(_, value)| value.trim());
            values.next()?.parse::<usize>().ok()
        };
        let usual = Self::default();
        Self {
            array_size: number("MaxArraySize").unwrap_or(usual.array_size),
            job_count: number("MaxJobCount").unwrap_or(usual.job_count),
        }
    }

    /// Most shards that a submission should have if nobody said how many: half of the controller's jobs are for others.
    pub fn shards(self) -> usize {
        (self.job_count / 2).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_controllers_configuration_is_read() {
        let text = "Configuration data as of 2026-11-21T10:00:00\nMaxArraySize            = 4001\nMaxDBDMsgs              = 20004\n\
                    MaxJobCount             = 25000\nMaxJobId                = 67043328\n";
        assert_eq!(Limits::parse(text), Limits { array_size: 4001, job_count: 25000 });
        assert_eq!(Limits::parse("no such thing"), Limits { array_size: 1001, job_count: 10_000 });
    }
}
