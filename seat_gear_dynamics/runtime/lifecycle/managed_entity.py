"""Parts of a node that follow its transitions."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, overload

from seat_gear_dynamics.runtime.lifecycle.state_machine import LifecycleState, TransitionCallbackReturn

_Method = TypeVar("_Method", bound=Callable[..., Any])


class ManagedEntity:
    """Something a managed node owns that is told of every transition; each callback here accepts it."""

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle configuring; `state` is the one before."""
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle cleaning up."""
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle shutting down."""
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle activating."""
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle deactivating."""
        return TransitionCallbackReturn.SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle an error in another callback."""
        return TransitionCallbackReturn.SUCCESS


class SimpleManagedEntity(ManagedEntity):
    """A managed entity that knows whether it is activated."""

    def __init__(self) -> None:
        self._enabled = False

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Note that the node is active."""
        self._enabled = True
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Note that the node is not active any more."""
        self._enabled = False
        return TransitionCallbackReturn.SUCCESS

    @property
    def is_activated(self) -> bool:
        """Whether it is activated."""
        return self._enabled

    @overload
    @staticmethod
    def when_enabled(wrapped: _Method) -> _Method: ...
    @overload
    @staticmethod
    def when_enabled(*, when_not_enabled: Callable[[], Any] | None = None) -> Callable[[_Method], _Method]: ...
    @staticmethod
    def when_enabled(wrapped: Any = None, *, when_not_enabled: Callable[[], Any] | None = None) -> Any:
        """Make a method do nothing, or call `when_not_enabled`, while the entity is not activated.

        Used as `@SimpleManagedEntity.when_enabled` with or without arguments; the method's own result is dropped.
        """

        def decorator(method: _Method) -> Callable[..., None]:
            @wraps(method)
            def only_when_enabled(self: SimpleManagedEntity, *args: Any, **kwargs: Any) -> None:
                if self._enabled:
                    method(self, *args, **kwargs)
                elif when_not_enabled is not None:
                    when_not_enabled()

            return only_when_enabled

        return decorator if wrapped is None else decorator(wrapped)
