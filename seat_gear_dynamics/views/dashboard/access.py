"""Who may see the dashboard and who may press its buttons: host names, origins and the token."""

import re
from hmac import compare_digest
from ipaddress import ip_address
from typing import Literal
from urllib.parse import urlsplit

Role = Literal["watch", "control"]

TOKEN_LENGTH = 16
"""Least number of characters of a token that is given."""
_HOST = re.compile(r"(?P<name>\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9._-]+)(:[0-9]{1,5})?", re.ASCII)


class AccessError(ValueError):
    """A setting that would let the wrong people in; the text is one sentence."""


class Access:
    """Decides from what a browser sends; holds no connection.

    A server on a loopback address shows the page to whoever is on the machine; anywhere else it wants the token. The
    buttons want the token everywhere, and exist only where `control` is allowed.

    A foreign page must not be able to make a browser talk to this server. Names other than `names` in the Host header
    are refused, because a name can be made to point here (DNS rebinding); literal addresses cannot, and are let in. The
    conversation's Origin must be this server's own.
    """

    def __init__(self, host: str, *, token: str | None = None, control: bool = False, names: tuple[str, ...] = ()):
        self.loopback = is_loopback(host)
        self.control = control
        if (control or not self.loopback) and token is None:
            raise AccessError(f"A dashboard on {host!r}{' with control' if control else ''} needs a token; give one.")
        if token is not None and (len(token) < TOKEN_LENGTH or not (token.isascii() and token.isprintable())):
            raise AccessError(
                f"The token has {len(token)} characters, expected at least {TOKEN_LENGTH}, printable ASCII; "
                f"let the dashboard make one."
            )
        self._token = token
        self._names = {"localhost", *(name.lower().rstrip(".") for name in (host, *names))}

    @property
    def wants_token(self) -> bool:
        """Whether nothing is shown without the token."""
        return not self.loopback

    def host_is_ours(self, header: str | None) -> bool:
        """Return whether a Host header names this server."""
        found = _HOST.fullmatch(header or "")
        if found is None:
            return False
        name = found["name"].strip("[]").lower().rstrip(".")
        try:
            address = ip_address(name)
        except ValueError:
            return name in self._names
        return address.is_loopback or not self.loopback

    def origin_is_ours(self, origin: str | None, host: str | None) -> bool:
        """Return whether the Origin of a conversation is the page that this server gave out as `host`."""
        if not origin or not host:
            return False
        try:
            parts = urlsplit(origin)
        except ValueError:
            return False
        return parts.scheme in ("http", "https") and parts.netloc.lower() == host.lower()

    def role(self, token: str | None) -> Role | None:
        """Return what the bearer of `token` may do; None: nothing."""
        if self._token is None:
            return "watch"
        if token and compare_digest(token.encode(), self._token.encode()):
            return "control" if self.control else "watch"
        return None if self.wants_token or token else "watch"


def is_loopback(host: str) -> bool:
    """Return whether only this machine reaches a server on `host`."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"
