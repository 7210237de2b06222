"""A page that stands for that of the viewer, which is built from other sources."""

__all__ = ["VIEWER"]

VIEWER = (
    "<!doctype html><html lang=en><title>A viewer</title>\n<!-- elastomorph scene -->\n"
    "<p id=said></p><script>document.getElementById('said').textContent = 'alive & \"well\"'"
    "</script></html>"
)
