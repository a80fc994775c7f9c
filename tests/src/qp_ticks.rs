//! Files of problems of consecutive ticks, as programs in other languages read them quickly.
//!
//! # Format
//! Little-endian. `WBQPTK01`, the number of problems (u32), then each: n, m, 1 if nothing precedes it (a warm start
//! begins there) else 0, 0 (u32); H and A by rows, g between them, the limits of the rows, lower then upper, those of
//! the variables (f64, infinities for none); permanent identities of the rows, then of the variables (u32).

use std::io::{self, Error, ErrorKind, Read, Write};

use wbqp::qp::{Capacity, Qp, QpError, RowId, VarId};

const MAGIC: &[u8; 8] = b"WBQPTK01";
/// More variables or rows than any problem here has.
const LARGEST: u32 = 10_000;

/// A problem, and whether it follows the one before it in time.
#[derive(Clone, Debug)]
pub struct Tick {
    /// Nothing precedes it.
    pub is_first: bool,
    /// The problem.
    pub qp: Qp,
}

/// Writes all problems.
///
/// # Errors
/// The writer's.
pub fn write(to: &mut impl Write, ticks: &[Tick]) -> io::Result<()> {
    to.write_all(MAGIC)?;
    to.write_all(&(ticks.len() as u32).to_le_bytes())?;
    for Tick { is_first, qp } in ticks {
        for value in [qp.n() as u32, qp.m() as u32, u32::from(*is_first), 0] {
            to.write_all(&value.to_le_bytes())?;
        }
        let limits = [qp.row_lower(), qp.row_upper(), qp.lower(), qp.upper()];
        for list in [qp.h(), qp.g(), qp.a()].into_iter().chain(limits) {
            for value in list {
                to.write_all(&value.to_le_bytes())?;
            }
        }
        let rows = qp.rows().iter().map(|row| row.index());
        for id in rows.chain(qp.vars().iter().map(|var| var.index())) {
            to.write_all(&(id as u32).to_le_bytes())?;
        }
    }
    to.flush()
}

/// Reads what [`write`](fn@write) has written; every problem has the same capacity.
///
/// # Errors
/// The reader's, and a file that is not of this format.
pub fn read(from: &mut impl Read) -> io::Result<Vec<Tick>> {
    let mut magic = [0; 8];
    from.read_exact(&mut magic)?;
    if &magic != MAGIC {
        return Err(invalid("the file does not begin with `WBQPTK01`"));
    }
    let count = word(from)?;
    let mut parts = Vec::new();
    for _ in 0..count {
        parts.push(Parts::read(from)?);
    }
    let capacity = Capacity {
        vars: parts.iter().map(|p| p.vars.len()).max().unwrap_or(0),
        rows: parts.iter().map(|p| p.rows.len()).max().unwrap_or(0),
    };
    parts.into_iter().map(|p| p.into_tick(capacity)).collect()
}

/// A problem as the file has it.
struct Parts {
    is_first: bool,
    h: Vec<f64>,
    g: Vec<f64>,
    a: Vec<f64>,
    row_lower: Vec<f64>,
    row_upper: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    rows: Vec<u32>,
    vars: Vec<u32>,
}

impl Parts {
    fn read(from: &mut impl Read) -> io::Result<Self> {
        let (n, m, first, _) = (word(from)?, word(from)?, word(from)?, word(from)?);
        if n.max(m) > LARGEST {
            return Err(invalid("a problem of more than 10 000 variables or rows"));
        }
        let (n, m) = (n as usize, m as usize);
        Ok(Self {
            is_first: first != 0,
            h: numbers(from, n * n)?,
            g: numbers(from, n)?,
            a: numbers(from, m * n)?,
            row_lower: numbers(from, m)?,
            row_upper: numbers(from, m)?,
            lower: numbers(from, n)?,
            upper: numbers(from, n)?,
            rows: (0..m).map(|_| word(from)).collect::<io::Result<_>>()?,
            vars: (0..n).map(|_| word(from)).collect::<io::Result<_>>()?,
        })
    }

    fn into_tick(self, capacity: Capacity) -> io::Result<Tick> {
        let mut qp = Qp::new(capacity);
        let vars = self.vars.iter().map(|&id| VarId::new(id));
        qp.reset(vars).map_err(refused)?;
        qp.h_mut().copy_from_slice(&self.h);
        qp.g_mut().copy_from_slice(&self.g);
        let n = self.vars.len();
        for (i, &id) in self.rows.iter().enumerate() {
            let row = qp.push_row(RowId::new(id), self.row_lower[i], self.row_upper[i]);
            let row = row.map_err(refused)?;
            row.copy_from_slice(&self.a[i * n..(i + 1) * n]);
        }
        let (lower, upper) = qp.bounds_mut();
        lower.copy_from_slice(&self.lower);
        upper.copy_from_slice(&self.upper);
        Ok(Tick {
            is_first: self.is_first,
            qp,
        })
    }
}

fn word(from: &mut impl Read) -> io::Result<u32> {
    let mut bytes = [0; 4];
    from.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}

fn numbers(from: &mut impl Read, count: usize) -> io::Result<Vec<f64>> {
    let mut bytes = [0; 8];
    let mut number = || {
        from.read_exact(&mut bytes)?;
        Ok(f64::from_le_bytes(bytes))
    };
    (0..count).map(|_| number()).collect()
}

fn refused(error: QpError) -> Error {
    Error::new(ErrorKind::InvalidData, error)
}

fn invalid(what: &str) -> Error {
    Error::new(ErrorKind::InvalidData, what)
}
