//! `lacquer check`: modules are checked, and everything that is wrong is said. Exit status 0 if nothing is,
//! 1 if there are errors, 2 if the command was called wrongly.

use super::{Fail, SearchPaths, files_below};
use lacquer::{Error, Module, Session};
use mdl_frontend::diagnostics::{Record, Severity};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// Arguments of `check`.
#[derive(clap::Args)]
pub struct Args {
    /// Files (.mdl, .mdle, .mdr), or folders whose modules are all checked
    #[arg(required = true, value_name = "FILE|FOLDER")]
    paths: Vec<PathBuf>,
    #[command(flatten)]
    search: SearchPaths,
    /// How diagnostics are written
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
    /// Count warnings as errors
    #[arg(long)]
    deny_warnings: bool,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Format {
    /// For people
    Human,
    /// One JSON object a line
    Json,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), Fail> {
    let session = args.search.session()?;
    let mut subjects = Vec::new();
    for path in &args.paths {
        if path.is_dir() {
            session.add_search_path(path)?;
            let below = files_below(path, &["mdl", "mdle", "mdr"])?;
            if below.is_empty() {
                eprintln!("warning: no module lies below {}", path.display());
            }
            below.into_iter().for_each(|file| subjects.extend(subjects_in(&session, file)));
        } else {
            subjects.extend(subjects_in(&session, path.clone()));
        }
    }
    let (mut errors, mut warnings) = (0, 0);
    for (subject, result) in check_all(&session, &subjects) {
        match result {
            Ok(module) => {
                let (e, w) = print(&module, args.format);
                errors += e;
                warnings += w;
            }
            Err(error) => {
                errors += 1;
                unreadable(subject, &error, args.format);
            }
        }
    }
    if args.format == Format::Human {
        let modules = subjects.len();
        eprintln!(
            "{modules} module{} checked: {errors} errors, {warnings} warnings",
            if modules == 1 { "" } else { "s" }
        );
    }
    match errors > 0 || (args.deny_warnings && warnings > 0) {
        true => Err(Fail::Reported),
        false => Ok(()),
    }
}

/// What is checked.
enum Subject {
    /// A file with one module.
    File(PathBuf),
    /// A module of an archive.
    Archived(PathBuf, String),
    /// An archive that cannot be read.
    Broken(PathBuf, Error),
}

/// The modules of a file: one, unless it is an archive.
fn subjects_in(session: &Session, file: PathBuf) -> Vec<Subject> {
    if file.extension().is_none_or(|extension| extension != "mdr") {
        return vec![Subject::File(file)];
    }
    match session.open_archive(&file) {
        Ok(names) => names.into_iter().map(|name| Subject::Archived(file.clone(), name)).collect(),
        Err(error) => vec![Subject::Broken(file, error)],
    }
}

/// Checks on all cores; results in the order of the subjects.
fn check_all<'s>(session: &Session, subjects: &'s [Subject]) -> Vec<(&'s Path, Result<Module, String>)> {
    let next = std::sync::atomic::AtomicUsize::new(0);
    let check = |subject: &'s Subject| match subject {
        Subject::File(file) => (&**file, session.open(file).map_err(|e| e.to_string())),
        Subject::Archived(file, name) => (&**file, session.import(name).map_err(|e| e.to_string())),
        Subject::Broken(file, error) => (&**file, Err(error.to_string())),
    };
    let work = || {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            let Some(subject) = subjects.get(index) else { return done };
            done.push((index, check(subject)));
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(subjects.len().max(1));
    let mut results: Vec<_> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        handles.into_iter().flat_map(|handle| handle.join().expect("checking does not panic")).collect()
    });
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Writes the diagnostics of a module; gives the numbers of errors and warnings.
fn print(module: &Module, format: Format) -> (usize, usize) {
    let colour = std::io::stderr().is_terminal();
    for diagnostic in module.diagnostics() {
        match format {
            Format::Human => eprint!("{}", module.render(diagnostic, colour)),
            Format::Json => {
                let record = Record::new(diagnostic, |file| module.source(file));
                println!("{}", super::json::line(&record));
            }
        }
    }
    let errors = module.diagnostics().iter().filter(|d| d.severity == Severity::Error).count();
    (errors, module.diagnostics().len() - errors)
}

/// A file that could not be read.
fn unreadable(file: &Path, error: &str, format: Format) {
    match format {
        Format::Human => eprintln!("error: {error}"),
        Format::Json => {
            let record = Record {
                code: "E0000",
                severity: "error",
                message: error.to_string(),
                file: file.display().to_string(),
                line: 1,
                column: 1,
                help: None,
            };
            println!("{}", super::json::line(&record));
        }
    }
}
