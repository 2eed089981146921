//! `lacquer doc`: a page of Markdown per module, from its declarations and annotations.

use super::{Fail, SearchPaths, modules_below, write_file};
use lacquer::Error;
use std::io::IsTerminal;
use std::path::PathBuf;

/// Arguments of `doc`.
#[derive(clap::Args)]
pub struct Args {
    /// Files, or folders whose modules are all documented
    #[arg(required = true, value_name = "FILE|FOLDER")]
    paths: Vec<PathBuf>,
    #[command(flatten)]
    search: SearchPaths,
    /// Write pages into this folder, named after the modules; without it they are printed
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), Fail> {
    let session = args.search.session()?;
    let mut files = Vec::new();
    for path in &args.paths {
        if path.is_dir() {
            session.add_search_path(path)?;
            files.extend(modules_below(path)?);
        } else {
            files.push(path.clone());
        }
    }
    let mut failed = false;
    for file in &files {
        let module = session.open(file)?;
        if module.has_errors() {
            failed = true;
            for diagnostic in module.diagnostics().iter().filter(|diagnostic| diagnostic.is_error()) {
                eprint!("{}", module.render(diagnostic, std::io::stderr().is_terminal()));
            }
            continue;
        }
        let page = mdl_frontend::doc::page(module.checked());
        match &args.output {
            None => println!("{page}"),
            Some(folder) => {
                let io = |source| Error::Io { path: folder.clone(), source };
                std::fs::create_dir_all(folder).map_err(io)?;
                let name = module.name().trim_start_matches("::").replace("::", ".");
                write_file(&folder.join(format!("{name}.md")), page.as_bytes())?;
            }
        }
    }
    match failed {
        true => Err(Fail::Reported),
        false => Ok(()),
    }
}
