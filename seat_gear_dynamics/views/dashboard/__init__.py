"""The dashboard: what the listener hears in, one page in the browser out, over a server of its own."""
