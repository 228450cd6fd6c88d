"""Psychometric functions: P(x) = lambda/2 + (1 - lambda) Phi((x - mu)/sigma), Phi the cumulative normal distribution, lambda the lapse rate,
by the posterior of (mu, log sigma, lambda) on a grid.

The prior of mu and log sigma is flat, that of lambda is (1 - lambda)^(b - 1) with the study's own lapse rate as its mean: few data tell
lapses from slope (Wichmann, Hill, Percept. Psychophys. 63, 2001), and a rate that is held at a wrong value biases the slope. Estimates are
medians and intervals the 2.5 and 97.5 percentiles of the marginal posterior (Schuett et al., Vision Res. 122, 2016). They condition on the
levels that were shown, so that staircases and adaptive methods, which choose levels by answers, need nothing of their own; a bootstrap at
those levels would need it, and says that an interval has no width where all its draws are separated alike.

PSE = mu; JND = x(0.75) - x(0.5) of Phi, the slope is that of P at mu. Data may not bound sigma: where every answer below some level is one
and above it the other, any smaller sigma is as likely; where answers do not follow x, any larger one. A side on which the likelihood, with
mu and lambda at their best, stays within exp(-1.92) of its largest value to the end of the grid is open: JND is not identified, and its
interval runs from 0, or to infinity, to the value at which the likelihood falls by that factor.

Levels of adaptive methods: the one whose answer tells most about the parameters, I(x) = h(E p) - E h(p), h the entropy of an answer, E over
the posterior: of mu and sigma with lambda as given, psi (Kontsevich, Tyler, Vision Res. 39, 1999), or of all three, QUEST+ (Watson, J. Vision
17, 2017)."""
import math
from dataclasses import dataclass

import numpy as np
from scipy import special, stats

QUARTILE = 0.6744897501960817      # Phi^-1(0.75)
DENSITY = 0.3989422804014327       # of Phi at 0
TINY = 1e-12
LARGEST_SIGMA, SMALLEST_SIGMA = 30.0, 1e-3   # of the range of x: the grid's ends
MOST_LAPSE = 0.15                  # of the grid; beyond it a subject does not attend
BOUND = 1.92                       # fall of the log likelihood at the ends of a 95 % interval: chi^2_1 / 2
COARSE, FINE = (41, 62, 8), (41, 61, 12)     # values of mu, log sigma, lambda
WIDE = 5.0                         # half width of the fine grid in standard deviations
REPLICAS = 500                     # data sets drawn for the goodness of fit


@dataclass
class Fit:
    pse: float
    jnd: float               # NaN where it is not identified
    slope: float
    lapse: float
    pse_interval: tuple
    jnd_interval: tuple      # (0, b) or (a, inf) where it is not identified
    identified: bool
    trials: int
    fit_p: float             # share of data sets of the posterior with a larger deviance
    grid: object             # Posterior

    def band(self, x):
        """(low, median, high) of P at each x, pointwise."""
        return self.grid.band(x)

    def jnd_text(self, form='{:.4f}'):
        low, high = (form.format(value) if 0 < value < math.inf else '' for value in self.jnd_interval)
        if self.identified:
            return f'JND {form.format(self.jnd)} ({low} to {high})'
        return 'JND not identified' + (f', at most {high}' if high else f', at least {low}' if low else '')


def probability(x, mu, sigma, lapse):
    return 0.5 * lapse + (1 - lapse) * special.ndtr((x - mu) / sigma)


def grouped(x, positive):
    """Levels, counts, positives of single trials."""
    levels, index = np.unique(np.round(np.asarray(x, float), 12), return_inverse=True)
    return levels, np.bincount(index).astype(float), np.bincount(index, weights=np.asarray(positive, float))


def lapse_prior(rates, mean):
    """Weight of each rate: Beta(1, 1/mean - 1); a mean of 0 leaves no lapses."""
    weight = (1 - rates) ** (1 / mean - 2) if mean > 0 else (rates == rates.min()).astype(float)
    return weight / weight.sum()


class Posterior:
    """Over a grid of mu, log sigma and lambda, after `positive` of `count` answers at each level `x`."""

    def __init__(self, mu, log_sigma, lapse, mean_lapse):
        self.mu, self.log_sigma, self.lapse = mu, log_sigma, lapse
        prior = np.maximum(lapse_prior(lapse, mean_lapse), 1e-300)
        self.log = np.broadcast_to(np.log(prior), (len(mu), len(log_sigma), len(lapse))).copy()

    def p(self, x):
        """P at x for each point of the grid."""
        rise = special.ndtr((x - self.mu[:, None]) * np.exp(-self.log_sigma))
        return np.clip(0.5 * self.lapse + (1 - self.lapse) * rise[..., None], TINY, 1 - TINY)

    def observe(self, x, count, positive):
        for level, n, k in zip(x, count, positive):
            p = self.p(level)
            self.log += k * np.log(p) + (n - k) * np.log1p(-p)
        return self

    def weights(self):
        w = np.exp(self.log - self.log.max())
        return w / w.sum()

    def quantiles(self, axis, levels):
        """Of the marginal posterior of mu (axis 0), log sigma (1) or lambda (2): linear within its cells."""
        grid = (self.mu, self.log_sigma, self.lapse)[axis]
        mass = self.weights().sum(axis=tuple(a for a in range(3) if a != axis))
        return np.interp(levels, np.cumsum(mass) - 0.5 * mass, grid)

    def profile(self):
        """Of log sigma: the largest log posterior density over mu and lambda, less that over all."""
        best = self.log.max(axis=(0, 2))
        return best - best.max()

    def around(self, shape, mean_lapse):
        """A finer grid about what this one found, empty."""
        w, finer = self.weights(), []
        for axis, grid in enumerate((self.mu, self.log_sigma, self.lapse)):
            mass = w.sum(axis=tuple(a for a in range(3) if a != axis))
            mean, spacing = float(mass @ grid), grid[1] - grid[0] if len(grid) > 1 else 0.0
            half = max(WIDE * math.sqrt(float(mass @ (grid - mean) ** 2)), 1.5 * spacing)
            if axis == 2:
                finer.append(rates(mean_lapse, shape[2], max(0.0, mean - half), min(MOST_LAPSE, mean + half)))
            else:
                finer.append(np.linspace(max(grid[0], mean - half), min(grid[-1], mean + half), shape[axis]))
        return Posterior(*finer, mean_lapse)

    def band(self, x):
        w, rows = self.weights().ravel(), []
        kept = w > 1e-7 * w.max()
        for value in x:
            p = self.p(value).ravel()[kept]
            order = np.argsort(p)
            total = np.cumsum(w[kept][order])
            rows.append(np.interp([0.025, 0.5, 0.975], total / total[-1], p[order]))
        return np.array(rows).T

    def draws(self, number, seed):
        """(mu, sigma, lambda) of `number` points drawn by their weight."""
        chosen = np.random.default_rng(seed).choice(self.log.size, number, p=self.weights().ravel())
        m, s, r = np.unravel_index(chosen, self.log.shape)
        return self.mu[m], np.exp(self.log_sigma[s]), self.lapse[r]


def rates(mean, number, low=0.0, high=MOST_LAPSE):
    """Middles of equal cells; 0 alone where no lapses are expected."""
    return low + (np.arange(number) + 0.5) * (high - low) / number if mean > 0 else np.zeros(1)


def whole_grid(x, mean_lapse):
    """All that data at these levels may say."""
    spread = float(np.ptp(x)) or 1.0
    return Posterior(np.linspace(x.min() - spread, x.max() + spread, COARSE[0]),
                     np.linspace(math.log(SMALLEST_SIGMA * spread), math.log(LARGEST_SIGMA * spread), COARSE[1]),
                     rates(mean_lapse, COARSE[2]), mean_lapse)


def deviance(count, positive, p):
    p = np.clip(p, TINY, 1 - TINY)
    return 2 * (special.xlogy(positive, positive / (count * p)) +
                special.xlogy(count - positive, (count - positive) / (count * (1 - p)))).sum(axis=-1)


def goodness(x, count, positive, grid, seed):
    """Posterior predictive p of the deviance (Gelman, Meng, Stern, Stat. Sinica 6, 1996): near 0 where no such function gave the data."""
    mu, sigma, lapse = (v[:, None] for v in grid.draws(REPLICAS, seed))
    p = probability(x, mu, sigma, lapse)
    drawn = np.random.default_rng(seed + 1).binomial(count.astype(int), p)
    return float((deviance(count, drawn, p) >= deviance(count, positive, p)).mean())


def open_ends(coarse):
    """(low, high) of log sigma where the likelihood has fallen; None at a side to which it does not fall."""
    kept = np.flatnonzero(coarse.profile() > -BOUND)
    grid = coarse.log_sigma
    return (None if kept[0] == 0 else float(grid[kept[0]])), (None if kept[-1] == len(grid) - 1 else float(grid[kept[-1]]))


def fit(x, count, positive, lapse=0.0, seed=1):
    """A Fit, or None where the data cannot show a slope: one level, or all answers alike. `lapse`: mean of the prior."""
    x, count, positive = (np.asarray(v, float) for v in (x, count, positive))
    if len(x) < 2 or positive.sum() in (0, count.sum()):
        return None
    coarse = whole_grid(x, lapse).observe(x, count, positive)
    low, high = open_ends(coarse)
    grid, identified = coarse, low is not None and high is not None
    for _ in range(2 if identified else 0):
        grid = grid.around(FINE, lapse).observe(x, count, positive)
    pse_low, pse, pse_high = (float(q) for q in grid.quantiles(0, [0.025, 0.5, 0.975]))
    s_low, s, s_high = (math.exp(q) for q in grid.quantiles(1, [0.025, 0.5, 0.975]))
    rate = float(grid.quantiles(2, [0.5])[0]) if len(grid.lapse) > 1 else 0.0
    interval = (QUARTILE * s_low, QUARTILE * s_high) if identified else \
        (0.0 if low is None else QUARTILE * math.exp(low), math.inf if high is None else QUARTILE * math.exp(high))
    return Fit(pse, QUARTILE * s if identified else math.nan, (1 - rate) * DENSITY / s if identified else math.nan, rate,
               (pse_low, pse_high), interval, identified, int(count.sum()), goodness(x, count, positive, grid, seed), grid)


class Adaptive:
    """Chooses levels for `rules` (study.Adaptive). Nothing is random: the same answers, the same levels."""

    def __init__(self, rules, lapse):
        reach = math.log(rules.greatest)
        self.rules, self.trials = rules, 0
        self.x = np.linspace(-reach, reach, rules.levels)
        free = rules.method == 'quest_plus' and lapse > 0
        self.posterior = Posterior(np.linspace(-0.5 * reach, 0.5 * reach, 31),
                                   np.linspace(math.log(reach / 50), math.log(3 * reach), 41),
                                   rates(lapse, 6) if free else np.array([lapse]), lapse if free else 0.0)
        self.p = np.stack([self.posterior.p(x).ravel() for x in self.x])
        self.entropy = special.entr(self.p) + special.entr(1 - self.p)

    def answer(self, level, positive):
        self.trials += 1
        p = self.p[int(np.argmin(np.abs(self.x - level)))].reshape(self.posterior.log.shape)
        self.posterior.log += np.log(p if positive else 1 - p)

    def next_level(self):
        w = self.posterior.weights().ravel()
        mean = self.p @ w
        return float(self.x[int(np.argmax(special.entr(mean) + special.entr(1 - mean) - self.entropy @ w))])

    def width(self):
        """Of the JND's 95 % interval, over its median."""
        low, middle, high = np.exp(self.posterior.quantiles(1, [0.025, 0.5, 0.975]))
        return float((high - low) / middle)

    @property
    def done(self):
        enough = self.trials >= self.rules.least_trials and self.rules.width > 0 and self.width() <= self.rules.width
        return enough or self.trials >= self.rules.max_trials


def regression(x, y):
    """Slope, its standard error and p over trials: learning curves."""
    if len(x) < 3 or np.ptp(x) == 0:
        return float('nan'), float('nan'), float('nan')
    found = stats.linregress(x, y)
    return float(found.slope), float(found.stderr), float(found.pvalue)
