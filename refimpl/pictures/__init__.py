"""Pictures and animations; nothing else imports Matplotlib.

- `plot`: strips of poses, curves, scatters.   `player`: an animation for a browser.
"""
