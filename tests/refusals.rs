//! Every bad input that was tried, as a list of commands with what they answer: `tests/cmd/usage.trycmd`.
//!
//! A command's line begins with `$`, its exit code with `?`, its message follows; `[..]` stands for anything.

use std::process::Command;

#[test]
fn bad_input_is_refused_in_the_words_of_the_list() {
    let folder = tempfile::tempdir().unwrap();
    let list = include_str!("cmd/usage.trycmd");
    let mut tried = 0;
    for entry in list.split("\n$ ").skip(1) {
        let lines: Vec<&str> = entry.lines().filter(|l| !l.starts_with("```")).collect();
        let [command, code, told @ ..] = lines.as_slice() else {
            panic!("{entry}: a command, a code and a message")
        };
        let mut words = command.split(' ');
        assert_eq!(words.next(), Some("hollowcast"));
        let output = Command::new(env!("CARGO_BIN_EXE_hollowcast"))
            .args(words)
            .current_dir(folder.path())
            .env_remove("RUST_LOG")
            .output()
            .unwrap();
        let expected = told.join("\n");
        let answer = String::from_utf8(output.stderr).unwrap();
        assert_eq!(
            Some(*code),
            output.status.code().map(|c| format!("? {c}")).as_deref(),
            "{command}: {answer}"
        );
        assert!(
            is_like(answer.trim(), expected.trim()),
            "{command}: {answer}"
        );
        assert!(output.stdout.is_empty(), "{command}");
        tried += 1;
    }
    assert!(tried > 15, "{tried} commands were tried");
    // Nothing was written on the way to a refusal.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Whether a text is the pattern, whose `[..]` stands for anything.
fn is_like(text: &str, pattern: &str) -> bool {
    match pattern.split_once("[..]") {
        None => text == pattern,
        Some((before, after)) => text
            .strip_prefix(before)
            .is_some_and(|rest| rest.ends_with(after)),
    }
}
