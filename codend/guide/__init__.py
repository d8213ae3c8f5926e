"""The manual, in Markdown, shipped with the package."""
