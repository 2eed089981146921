//! Binding a batch to compiled code: the context and what it points to.
//!
//! Whole groups of points are computed in place. The last, partial group is computed on copies: every
//! column's last points in a row, filled up with the last one, so that all lanes hold a real
//! point; of the results as many are copied back as there are points.

use super::Inner;
use super::abi::{ArgWords, CONSTANTS, FAULT, HOST};
use crate::batch::{Argument, Batch, Input, Mode, Output};
use crate::error::Fault;
use crate::externs::{Externs, HostFunction};
use crate::texture::TextureFunctions;

/// The points of the largest group.
type Row = [u32; 8];

/// What compiled code reads and writes, as addresses, and the storage that is not the batch's.
pub struct Columns<'b> {
    words: Vec<u64>,
    rows: Vec<Row>,
    /// Columns for single values bound to leaves that vary.
    filled: Vec<Vec<u32>>,
    tables: Vec<Vec<[u64; 2]>>,
    /// Contents of buffers too short to be indexed.
    padded: Vec<Vec<u32>>,
    host: Vec<&'b dyn HostFunction>,
    /// Bytes in every column.
    bytes: usize,
}

impl Columns<'_> {
    /// The context.
    pub fn context(&mut self) -> *mut u64 {
        self.words.as_mut_ptr()
    }

    /// Panics unless the columns hold everything between two offsets.
    pub fn check(&self, begin: usize, end: usize) {
        assert!(begin <= end && end <= self.bytes, "columns are read within their length");
    }
}

/// Which points the columns hold.
#[derive(Clone, Copy)]
struct Points {
    first: usize,
    count: usize,
    /// Whether they are copied to rows.
    copied: bool,
}

impl Input<'_> {
    /// The address of the column, if it is one.
    fn column(&self) -> Option<u64> {
        Some(match *self {
            Input::F32s(c) => c.as_ptr() as u64,
            Input::I32s(c) => c.as_ptr() as u64,
            Input::U32s(c) => c.as_ptr() as u64,
            _ => return None,
        })
    }

    /// The bits at a point.
    fn at(&self, point: usize) -> u32 {
        match *self {
            Input::F32s(c) => c[point].to_bits(),
            Input::I32s(c) => c[point] as u32,
            Input::U32s(c) => c[point],
            _ => self.word().expect("columns of f64 are refused"),
        }
    }
}

/// Runs a kernel on a batch that fits it.
pub fn run(k: &Inner, batch: &mut Batch<'_>) -> Result<(), Fault> {
    let textures = batch.textures.map(TextureFunctions::new);
    let textures = textures.as_ref().map_or_else(Externs::new, TextureFunctions::externs);
    let whole = batch.len / k.group * k.group;
    if whole > 0 {
        compute(k, batch, &textures, Points { first: 0, count: whole, copied: false })?;
    }
    if whole < batch.len {
        compute(k, batch, &textures, Points { first: whole, count: batch.len - whole, copied: true })?;
    }
    Ok(())
}

fn compute(k: &Inner, batch: &mut Batch<'_>, textures: &Externs<'_>, points: Points) -> Result<(), Fault> {
    let mut outputs = std::mem::take(&mut batch.outputs);
    let bound = bind(k, batch, textures, points, &mut outputs);
    let mut columns = match bound {
        Ok(columns) => columns,
        Err(e) => {
            batch.outputs = outputs;
            return Err(e);
        }
    };
    let end = columns.bytes;
    let fault = k.code.call(&mut columns, 0, end);
    if points.copied {
        let first = columns.rows.len() - outputs.len();
        for (row, output) in columns.rows[first..].iter().zip(&mut outputs) {
            for (i, &bits) in row.iter().take(points.count).enumerate() {
                let point = points.first + i;
                match output {
                    Output::F32(c) => c[point] = f32::from_bits(bits),
                    Output::I32(c) => c[point] = bits as i32,
                    Output::U32(c) => c[point] = bits,
                    Output::Skip | Output::F64(_) => {}
                }
            }
        }
    }
    batch.outputs = outputs;
    if fault == 0 {
        return Ok(());
    }
    let at = points.first + columns.words[FAULT] as usize / 4;
    Err(k.fault(fault, at))
}

fn bind<'b>(
    k: &Inner,
    batch: &Batch<'b>,
    textures: &Externs<'b>,
    points: Points,
    outputs: &mut [Output<'_>],
) -> Result<Columns<'b>, Fault> {
    // Addresses of rows are handed out while rows are added, so they must not move.
    let leaves: usize = k.interface.args.iter().map(|a| a.kinds.len()).sum();
    let mut c = Columns {
        words: vec![0; k.abi.len],
        rows: Vec::with_capacity(leaves + outputs.len()),
        filled: Vec::new(),
        tables: Vec::new(),
        padded: Vec::new(),
        host: Vec::new(),
        bytes: 4 * if points.copied { k.group } else { points.count },
    };
    for &index in &k.found.host {
        let name = &k.names[index];
        let own = batch.externs.get(name).or_else(|| textures.get(name));
        let unbound = || Fault::Binding(format!("the host function `{name}` is not bound"));
        c.host.push(own.or_else(|| super::cold::function(name)).ok_or_else(unbound)?);
    }
    c.words[HOST] = c.host.as_ptr() as u64;
    c.words[CONSTANTS] = k.found.constants.as_ptr() as u64;
    for (binding, words) in batch.args.iter().zip(&k.abi.args) {
        match (binding, words) {
            (Argument::Words(w), &ArgWords::Words(word)) => c.words[word] = w.as_ptr() as u64,
            (Argument::Leaves(inputs), ArgWords::Leaves(words)) => {
                for (input, &(word, mode)) in inputs.iter().zip(words) {
                    c.words[word] = c.leaf(input, mode, points);
                }
            }
            (Argument::Leaves(inputs), &ArgWords::Words(word)) => {
                let values = inputs.iter().map(|i| i.at(0)).collect::<Vec<_>>();
                c.words[word] = values.as_ptr() as u64;
                c.filled.push(values);
            }
            (Argument::Leaves(inputs), &ArgWords::Columns(word)) => {
                let table = inputs.iter().map(|input| c.column(input, points)).collect::<Vec<_>>();
                c.words[word] = table.as_ptr() as u64;
                c.tables.push(table);
            }
            (Argument::Words(_), _) => unreachable!("the interface was checked"),
        }
    }
    for (i, output) in outputs.iter_mut().enumerate() {
        let address = match output {
            Output::F32(o) => o.as_mut_ptr() as u64,
            Output::I32(o) => o.as_mut_ptr() as u64,
            Output::U32(o) => o.as_mut_ptr() as u64,
            Output::Skip | Output::F64(_) => 0,
        };
        let [pointer, mask] = if points.copied {
            [c.row([0; 8]), u64::MAX]
        } else if address == 0 {
            [c.row([0; 8]), 0]
        } else {
            [address + 4 * points.first as u64, u64::MAX]
        };
        let at = k.abi.outputs + 2 * i;
        (c.words[at], c.words[at + 1]) = (pointer, mask);
    }
    c.buffers(k, batch)?;
    Ok(c)
}

impl Columns<'_> {
    fn row(&mut self, row: Row) -> u64 {
        assert!(self.rows.len() < self.rows.capacity(), "rows do not move");
        self.rows.push(row);
        self.rows.last().expect("a row was added").as_ptr() as u64
    }

    /// The last points of a column.
    fn tail(&mut self, input: &Input<'_>, points: Points) -> u64 {
        let row = std::array::from_fn(|i| input.at(points.first + i.min(points.count - 1)));
        self.row(row)
    }

    /// The context's word of a leaf passed by value.
    fn leaf(&mut self, input: &Input<'_>, mode: Mode, points: Points) -> u64 {
        match (mode, input.column()) {
            (Mode::Uniform, _) => u64::from(input.at(0)),
            _ if points.copied => self.tail(input, points),
            (Mode::Varying, Some(column)) => column + 4 * points.first as u64,
            (Mode::Varying, None) => {
                let column = vec![input.at(0); points.count];
                self.filled.push(column);
                self.filled.last().expect("a column was added").as_ptr() as u64
            }
        }
    }

    /// A column of a table.
    fn column(&mut self, input: &Input<'_>, points: Points) -> [u64; 2] {
        match input.column() {
            Some(_) if points.copied => [self.tail(input, points), u64::MAX],
            Some(column) => [column + 4 * points.first as u64, u64::MAX],
            None => [self.row([input.at(0); 8]), 0],
        }
    }

    fn buffers(&mut self, k: &Inner, batch: &Batch<'_>) -> Result<(), Fault> {
        for (i, size) in k.buffers.iter().enumerate() {
            let Some(size) = size else { continue };
            let words = batch.buffers.iter().find(|b| b.global.index() == i).map_or(&[][..], |b| b.words);
            let bytes = words.len() * 4;
            if bytes < size.least as usize {
                return Err(Fault::Binding(format!("buffer {i} has less than {} bytes", size.least)));
            }
            let mut address = words.as_ptr() as u64;
            if bytes < size.padded as usize {
                let mut copy = words.to_vec();
                copy.resize((size.padded as usize).div_ceil(4), 0);
                address = copy.as_ptr() as u64;
                self.padded.push(copy);
            }
            let at = k.abi.buffers + 2 * i;
            let bytes = bytes.min(u32::MAX as usize);
            (self.words[at], self.words[at + 1]) = (address, bytes as u64);
        }
        Ok(())
    }
}
