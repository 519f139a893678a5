//! What measurements were made on and with.

use serde::Serialize;

/// The machine and the program; adapters are reported with what they drew ([`crate::render::BackendInfo`]).
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// The processor's model, as it names itself; its architecture where it does not.
    pub cpu: String,
    /// Threads that run at once.
    pub cores: usize,
    /// The operating system.
    pub os: &'static str,
    /// This crate's version.
    pub hollowcast: &'static str,
    /// wgpu's, where it was known when this was built.
    pub wgpu: Option<&'static str>,
    /// The commit that this was built from, with `-dirty` where files differed from it; where it was known.
    pub commit: Option<&'static str>,
}

impl Machine {
    /// This one.
    pub fn this() -> Self {
        // Linux tells; elsewhere nothing does without a system call of its own.
        let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = told.lines().find_map(|line| {
            let (key, value) = line.split_once(':')?;
            (key.trim() == "model name").then(|| value.trim().to_owned())
        });
        Self {
            cpu: model.unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            os: std::env::consts::OS,
            hollowcast: env!("CARGO_PKG_VERSION"),
            wgpu: option_env!("HOLLOWCAST_WGPU"),
            commit: option_env!("HOLLOWCAST_COMMIT"),
        }
    }

    /// In words, in one line.
    pub fn words(&self) -> String {
        let mut words = format!(
            "{}, {} threads; hollowcast {}",
            self.cpu, self.cores, self.hollowcast
        );
        if let Some(commit) = self.commit {
            words = format!("{words} ({commit})");
        }
        if let Some(wgpu) = self.wgpu {
            words = format!("{words}, wgpu {wgpu}");
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_has_a_processor_with_a_core_in_one_line() {
        let machine = Machine::this();
        assert!(machine.cores > 0 && !machine.cpu.is_empty());
        assert!(!machine.words().contains('\n'));
        // Built from a lock file: the tests always are.
        assert!(machine.wgpu.is_some_and(|v| v.starts_with("30.")));
    }
}
