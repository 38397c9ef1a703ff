"""Maps that the server announces, from the link to the tick, and the localization worker."""
