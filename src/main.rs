//! The `vcsg` program.

fn main() -> std::process::ExitCode {
    vcsg::cli::run()
}
