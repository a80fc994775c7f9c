//! Files of controllers and scenarios, with the plug-ins that ship: what is said of mistakes, what short forms mean,
//! what the schema says, the same in code, and that no file makes loading panic, hang or take all memory.
//!
//! Refusals and round trips of texts without any of these plug-ins are tested in `framework/tests/configuration`.

mod binding;
mod broken_files;
mod fuzz_files;
mod hostile_files;
mod in_code;
mod json_schema;
mod meaning_of_numbers;
mod scenario_refusals;
mod scenario_sharing;
mod scenario_variants;
mod scenario_warnings;
mod short_configurations;
mod varied_case;
