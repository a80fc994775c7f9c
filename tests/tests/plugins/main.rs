//! Tasks, constraints and references that ship: in closed loop, and as the page of plug-ins lists them. That each of
//! them passes the authors' kit is checked in `allocation`, where allocations are counted.

mod catalogue;
mod changed;
mod plugin_table;
