"""Other libraries as backends of the conformance kit, for development: `refimpl check
tests.adapters.torch_backend:BACKEND`.
"""
