//! Settings in TOML, with what is wrong of them told by its line.

use serde::de::DeserializeOwned;

use crate::error::{Error, Result};

/// Parses a text.
///
/// # Errors
/// [`Error::Setting`] naming the line that is wrong, in one line.
pub(super) fn parse<T: DeserializeOwned>(text: &str) -> Result<T> {
    toml::from_str(text).map_err(|e| {
        let before = e.span().and_then(|span| text.get(..span.start));
        let line = before.unwrap_or_default().matches('\n').count() + 1;
        let reason = e.message().trim().replace('\n', " ");
        Error::setting(format!("line {line}"), reason)
    })
}
