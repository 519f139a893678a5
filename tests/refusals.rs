//! Every bad input that was tried: its exit code, and the one line that says what is wrong.

#[test]
fn bad_input_is_refused_in_one_line_with_exit_code_2() {
    trycmd::TestCases::new().case("tests/cmd/*.trycmd");
}
