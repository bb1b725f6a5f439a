"""Pictures and animations; nothing else imports Matplotlib.

- `plot`: strips of poses, root paths, curves.   `player`: an animation for a browser.
"""
