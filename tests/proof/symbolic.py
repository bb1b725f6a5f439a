"""Algebra with the package's own text: it runs on symbols in the place of numbers, and what comes
back is compared as formulas, for all numbers at once.
"""

from contextlib import contextmanager
from fractions import Fraction
from numbers import Rational
import operator
from unittest import mock

import numpy as np
import sympy

from refimpl.conformance import definitions_holden, definitions_nn
from refimpl.nn.sums import root


class Germ:
    """A function near a point: computed with as an expression, compared by its value there.

    Where no two of the compared numbers are equal at the point, a maximum takes the same one, and a
    relu lets the same ones through, in a whole neighbourhood: there the text is one polynomial.
    """

    def __init__(self, expression, value):
        self.expression, self.value = expression, value

    def _arithmetic(operation):
        def _of_two(self, other):
            if isinstance(other, np.ndarray):
                return NotImplemented
            other = _as_germ(other)
            return Germ(operation(self.expression, other.expression),
                        operation(self.value, other.value))
        return _of_two

    def _comparison(operation):
        def _of_two(self, other):
            value = getattr(other, "value", other)
            if value == self.value and sympy.expand(self.expression - expression(other)) != 0:
                raise ValueError("two numbers that are compared are equal at the point")
            return operation(self.value, value)
        return _of_two

    __add__ = __radd__ = _arithmetic(operator.add)
    __mul__ = __rmul__ = _arithmetic(operator.mul)
    __sub__, __rsub__ = _arithmetic(operator.sub), _arithmetic(lambda a, b: b - a)
    __truediv__, __rtruediv__ = _arithmetic(operator.truediv), _arithmetic(lambda a, b: b / a)
    __lt__, __gt__ = _comparison(operator.lt), _comparison(operator.gt)
    __le__, __ge__ = _comparison(operator.le), _comparison(operator.ge)
    __eq__ = _comparison(operator.eq)

    def __pow__(self, n):
        return Germ(self.expression ** n, self.value ** n)

    def __neg__(self):
        return self * -1

    def __abs__(self):
        return -self if self < 0 else self


# so that the checks of arguments let it through
Rational.register(Germ)


def _as_germ(number):
    if isinstance(number, Germ):
        return number
    number = Fraction(number)
    return Germ(sympy.Rational(number), number)


def expression(number):
    """The formula of a number of any kind."""
    if isinstance(number, (Germ, sympy.Expr)):
        return getattr(number, "expression", number)
    return sympy.Rational(Fraction(number))


def symbols(name, shape):
    """An array of this shape with a symbol in every entry."""
    names = [f"{name}_{'_'.join(map(str, place))}" for place in np.ndindex(shape)]
    return np.array([sympy.Symbol(s) for s in names], dtype=object).reshape(shape)


def germs(name, shape, rng):
    """The same near a random point of distinct fractions."""
    values = rng.permutation(np.arange(1, 4 * np.prod(shape, dtype=int) + 1))
    signs = rng.choice([-1, 1], values.size)
    found = [Germ(s, Fraction(int(sign * v), 7)) for s, sign, v
             in zip(symbols(name, shape).flat, signs, values)]
    return np.array([None, *found], dtype=object)[1:].reshape(shape)


def derivatives(y, dy, x):
    """d sum(dy y) / dx by the rules of calculus.   arrays of numbers  ->  formulas, of x's shape"""
    found = {expression(s): sympy.Integer(0) for s in x.flat}
    for upstream, of_y in zip(np.ravel(dy), np.ravel(y)):
        for addend in sympy.Add.make_args(expression(of_y)):
            term = expression(upstream) * addend
            for s in term.free_symbols & found.keys():
                found[s] += sympy.diff(term, s)
    return np.array([None, *found.values()], dtype=object)[1:].reshape(x.shape)


def difference(found, needed):
    """The first place where two arrays are not one formula, or their shapes; None where they
    are."""
    if np.shape(found) != np.shape(needed):
        return np.shape(found), np.shape(needed)
    found, needed = np.asarray(found, dtype=object), np.asarray(needed, dtype=object)
    return next((place for place in np.ndindex(found.shape)
                 if sympy.expand(expression(found[place]) - expression(needed[place])) != 0), None)


class _ExactNumPy:
    """NumPy for the definitions, whose loops ask it of floats only whether they are numbers."""

    def __getattr__(self, name):
        return getattr(np, name)

    def sqrt(self, x):
        return root(np.asarray(x, dtype=object))

    def isfinite(self, x):
        return np.ones(np.shape(x), bool)

    def isnan(self, x):
        return np.zeros(np.shape(x), bool)

    def full(self, shape, value):
        return np.full(shape, value, dtype=object)

    def asarray(self, x, dtype=None):
        return np.asarray(x, dtype=object)


@contextmanager
def exact_definitions():
    """Within it the kit's second derivations take exact numbers."""
    with (mock.patch.object(definitions_nn, "np", _ExactNumPy()),
          mock.patch.object(definitions_holden, "np", _ExactNumPy())):
        yield
