//! Every error of the library: what was wrong, in which file or field, and what was expected.
//!
//! Each variant's `Display` is one line without a trailing full stop. [`Error::is_bad_input`] tells what the user can
//! mend from what failed on its own: the command exits with 2 for the one and with 1 for the other.

use std::path::{Path, PathBuf};

/// The library's result.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be opened, read or written.
    #[error("{path}: {source}", path = shown(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        #[source]
        source: std::io::Error,
    },

    /// A file's content is not what its format asks for.
    #[error("{path}: {field}: {reason}", path = shown(path))]
    File {
        /// The file.
        path: PathBuf,
        /// The header field, or the part of the file, that is wrong.
        field: String,
        /// What is wrong with it and what was expected.
        reason: String,
    },

    /// A setting lies outside its range or contradicts another.
    #[error("{field}: {reason}")]
    Setting {
        /// The setting, by the name that the user gave it.
        field: String,
        /// What is wrong with it and what was expected.
        reason: String,
    },

    /// The data or picture is larger than the adapter takes; the text names the limit, its value and a way out.
    #[error("{0}")]
    Limit(String),

    /// No graphics adapter, or it was lost, or a pass failed on it.
    #[error("graphics adapter: {0}")]
    Gpu(String),

    /// The user asked to stop.
    #[error("cancelled")]
    Cancelled,
}

impl Error {
    /// An [`Error::Io`] about `path`.
    pub fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            source,
        }
    }

    /// An [`Error::File`] about a field of `path`.
    pub fn file(path: &Path, field: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::File {
            path: path.to_owned(),
            field: one_line(field.into()),
            reason: one_line(reason.into()),
        }
    }

    /// An [`Error::Setting`].
    pub fn setting(field: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Setting {
            field: one_line(field.into()),
            reason: one_line(reason.into()),
        }
    }

    /// An error about a setting as one about the file that sets it.
    pub fn in_file(self, path: &Path) -> Self {
        match self {
            Self::Setting { field, reason } => Self::file(path, field, reason),
            other => other,
        }
    }

    /// Whether the input is at fault (exit code 2) rather than the run (exit code 1).
    pub fn is_bad_input(&self) -> bool {
        match self {
            Self::File { .. } | Self::Setting { .. } | Self::Limit(_) => true,
            Self::Io { source, .. } => matches!(
                source.kind(),
                std::io::ErrorKind::NotFound
                    | std::io::ErrorKind::IsADirectory
                    | std::io::ErrorKind::NotADirectory
                    | std::io::ErrorKind::AlreadyExists
                    | std::io::ErrorKind::InvalidData
                    | std::io::ErrorKind::InvalidInput
                    | std::io::ErrorKind::InvalidFilename
                    | std::io::ErrorKind::PermissionDenied
            ),
            Self::Gpu(_) | Self::Cancelled => false,
        }
    }
}

/// A path, which a file's header may have named.
fn shown(path: &Path) -> String {
    one_line(path.display().to_string())
}

/// Reasons may quote a file's own text: what would end the line, or steer a terminal, is escaped.
fn one_line(text: String) -> String {
    if !text.contains(char::is_control) {
        return text;
    }
    let escape = |c: char| {
        let mut text = String::new();
        if c.is_control() {
            text.extend(c.escape_default());
        } else {
            text.push(c);
        }
        text
    };
    text.chars().map(escape).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_file_says_neither_ends_the_line_nor_steers_a_terminal() {
        let error = Error::file(Path::new("x"), "a\nb", "no \u{1b}[2Jfield \"\u{e9}\r\"");
        assert_eq!(
            error.to_string(),
            "x: a\\nb: no \\u{1b}[2Jfield \"\u{e9}\\r\""
        );
        assert_eq!(Error::setting("a", "b\tc").to_string(), "a: b\\tc");
    }
}
