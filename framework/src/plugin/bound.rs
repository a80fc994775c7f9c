//! Tasks and constraints as a controller runs them: parameters, running object and rows of one entry.

use std::{
    any::Any,
    fmt::{self, Debug},
};

use crate::{
    error::BindError,
    plugin::{
        AnyConstraint, AnyTask, Constraint, Layout, Remembered, Setup, Task, Tick,
        storage::RowStore,
    },
};

/// A task or constraint that was bound: its rows, and what runs. Made by the attributes
/// [`task`](macro@crate::task) and [`constraint`](macro@crate::constraint).
#[doc(hidden)] // named by the code of the attributes alone
#[derive(Debug)]
pub struct BoundPlugin {
    pub(crate) layout: Layout,
    pub(crate) running: Box<dyn Running>,
}

impl BoundPlugin {
    /// Binds a task.
    ///
    /// # Errors
    /// What the task refuses.
    pub fn task<T: Task + AnyTask>(
        parameters: &T,
        setup: &mut Setup<'_>,
    ) -> Result<Self, BindError> {
        let (layout, running) = parameters.bind(setup)?;
        let parameters = parameters.clone();
        Ok(Self {
            layout,
            running: Box::new(RunningTask {
                parameters,
                running,
            }),
        })
    }

    /// Binds a constraint.
    ///
    /// # Errors
    /// What the constraint refuses.
    pub fn constraint<C: Constraint + AnyConstraint>(
        parameters: &C,
        setup: &mut Setup<'_>,
    ) -> Result<Self, BindError> {
        let (layout, running) = parameters.bind(setup)?;
        let parameters = parameters.clone();
        Ok(Self {
            layout: layout.into(),
            running: Box::new(RunningConstraint {
                parameters,
                running,
            }),
        })
    }
}

/// What runs of an entry in a tick, whether task or constraint.
pub(crate) trait Running: Parametrised {
    fn update(&mut self, tick: &Tick<'_>, layout: &Layout, store: &mut RowStore);
    fn activate(&mut self);
}

/// A task with its parameters.
pub(super) struct RunningTask<T: Task> {
    pub(super) parameters: T,
    pub(super) running: T::Running,
}

/// A constraint with its parameters.
pub(super) struct RunningConstraint<C: Constraint> {
    pub(super) parameters: C,
    pub(super) running: C::Running,
}

/// What an entry holds: `dyn AnyTask` or `dyn AnyConstraint`.
#[doc(hidden)] // nobody implements or calls it
pub trait AnyPlugin: any::AnyPlugin {}

impl<P: any::AnyPlugin + ?Sized> AnyPlugin for P {}

/// Keeps [`AnyPlugin`] to the two.
mod any {
    use super::{AnyConstraint, AnyTask, BindError, BoundPlugin, Setup};

    pub trait AnyPlugin {
        const IS_TASK: bool;

        fn bind(&self, setup: &mut Setup<'_>) -> Result<BoundPlugin, BindError>;
        fn tag(&self) -> &'static str;
    }

    impl AnyPlugin for dyn AnyTask {
        const IS_TASK: bool = true;

        fn bind(&self, setup: &mut Setup<'_>) -> Result<BoundPlugin, BindError> {
            self.bind_any(setup)
        }

        fn tag(&self) -> &'static str {
            self.typetag_name()
        }
    }

    impl AnyPlugin for dyn AnyConstraint {
        const IS_TASK: bool = false;

        fn bind(&self, setup: &mut Setup<'_>) -> Result<BoundPlugin, BindError> {
            self.bind_any(setup)
        }

        fn tag(&self) -> &'static str {
            self.typetag_name()
        }
    }
}

/// What is asked of a running task or constraint outside of its update.
pub(crate) trait Parametrised: Debug + Send {
    /// Shows what is remembered from one update to the next.
    fn remembered(&mut self, numbers: &mut Remembered<'_>);
    /// Swaps the parameters for others of the same type, unchecked; nothing happens if they are of another.
    fn exchange(&mut self, parameters: &mut dyn Any);
    fn parameters_mut(&mut self) -> &mut dyn Any;
    /// Changes a copy of the parameters, and takes it over if it can still be bound to these rows.
    fn change(
        &mut self,
        change: &mut dyn FnMut(&mut dyn Any),
        setup: &mut Setup<'_>,
        layout: &Layout,
    ) -> Result<(), BindError>;
    /// The parameters as a table of a file, with `type`.
    ///
    /// # Errors
    /// Why they cannot be written.
    fn table(&self) -> Result<toml::Value, toml::ser::Error>;
    /// Takes parameters of the same type over if they can be bound to these rows.
    fn take(
        &mut self,
        parameters: Box<dyn Any>,
        setup: &mut Setup<'_>,
        layout: &Layout,
    ) -> Result<(), BindError>;
}

macro_rules! parametrised {
    ($running:ident, $plugin:ident, $any:ident) => {
        impl<P: $plugin + $any> Parametrised for $running<P> {
            fn remembered(&mut self, numbers: &mut Remembered<'_>) {
                self.parameters.remembered(&mut self.running, numbers);
            }

            fn exchange(&mut self, parameters: &mut dyn Any) {
                if let Some(other) = parameters.downcast_mut::<P>() {
                    std::mem::swap(&mut self.parameters, other);
                }
            }

            fn parameters_mut(&mut self) -> &mut dyn Any {
                &mut self.parameters
            }

            fn change(
                &mut self,
                change: &mut dyn FnMut(&mut dyn Any),
                setup: &mut Setup<'_>,
                layout: &Layout,
            ) -> Result<(), BindError> {
                let mut changed = self.parameters.clone();
                change(&mut changed);
                self.replace(changed, setup, layout)
            }

            fn table(&self) -> Result<toml::Value, toml::ser::Error> {
                let parameters: &dyn $any = &self.parameters;
                toml::Value::try_from(parameters)
            }

            fn take(
                &mut self,
                parameters: Box<dyn Any>,
                setup: &mut Setup<'_>,
                layout: &Layout,
            ) -> Result<(), BindError> {
                match parameters.downcast::<P>() {
                    Ok(parameters) => self.replace(*parameters, setup, layout),
                    Err(_) => Err(BindError::Other("is of another type".to_owned())),
                }
            }
        }

        impl<P: $plugin> $running<P> {
            fn replace(
                &mut self,
                parameters: P,
                setup: &mut Setup<'_>,
                layout: &Layout,
            ) -> Result<(), BindError> {
                let (bound, _) = parameters.bind(setup)?;
                let bound: Layout = bound.into();
                if bound != *layout {
                    return Err(BindError::Other(
                        "has other rows with these parameters: a new controller is needed"
                            .to_owned(),
                    ));
                }
                self.parameters = parameters;
                Ok(())
            }
        }

        impl<P: $plugin> Debug for $running<P> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.parameters.fmt(f)
            }
        }
    };
}

parametrised!(RunningTask, Task, AnyTask);
parametrised!(RunningConstraint, Constraint, AnyConstraint);
