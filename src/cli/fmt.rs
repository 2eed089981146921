//! `lacquer fmt`: modules are written in canonical form. Exit status 0 if all are, 1 if a module cannot be
//! parsed, or with `--check` if one is not in that form.

use super::{Fail, modules_below, write_file};
use lacquer::Error;
use mdl_frontend::diagnostics::render;
use mdl_frontend::format::format;
use std::io::IsTerminal;
use std::path::PathBuf;

/// Arguments of `fmt`.
#[derive(clap::Args)]
pub struct Args {
    /// Files, or folders whose modules are all formatted
    #[arg(required = true, value_name = "FILE|FOLDER")]
    paths: Vec<PathBuf>,
    /// Change nothing, name the files that would change
    #[arg(long)]
    check: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), Fail> {
    let mut files = Vec::new();
    for path in &args.paths {
        match path.is_dir() {
            true => files.extend(modules_below(path)?),
            false => files.push(path.clone()),
        }
    }
    let (mut failed, mut changed) = (false, 0);
    for file in &files {
        let io = |source| Error::Io { path: file.clone(), source };
        let text = std::fs::read_to_string(file).map_err(io)?;
        match format(&text, &file.display().to_string()) {
            Ok(formatted) if formatted == text => {}
            Ok(formatted) => {
                changed += 1;
                match args.check {
                    true => println!("{}", file.display()),
                    false => write_file(file, formatted.as_bytes())?,
                }
            }
            Err(unparsed) => {
                failed = true;
                let source = |_: &str| Some(unparsed.text.clone());
                for error in &unparsed.diagnostics {
                    eprint!("{}", render(error, source, std::io::stderr().is_terminal()));
                }
            }
        }
    }
    let plural = if files.len() == 1 { "" } else { "s" };
    let verb = if args.check { "would change" } else { "changed" };
    eprintln!("{} module{plural}, {changed} {verb}", files.len());
    match failed || (args.check && changed > 0) {
        true => Err(Fail::Reported),
        false => Ok(()),
    }
}
