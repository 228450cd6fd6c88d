"""Psychometric functions: P(x) = gamma + (1 - gamma - lambda) F((x - mu)/sigma), F the cumulative normal or logistic distribution, by
maximum likelihood, with parametric bootstrap intervals.

gamma and lambda are given, not fitted: a slope and a lapse rate from some hundred trials are confounded (Wichmann and Hill, Percept.
Psychophys. 63, 2001). PSE = mu; JND = x(0.75) - x(0.5) of F, the slope is that of P at mu. Intervals are the 2.5 and 97.5 percentiles of
fits to draws from the fitted function. The likelihood makes sigma a few per cent small: the median bias of log sigma that a first set of
draws shows is taken off the estimate, before the second set is drawn, and off the interval.

Many data sets are fitted at once, by Fisher scoring on (mu, log sigma) over arrays; scipy.optimize fits one at a time, and is its oracle
in the tests."""
from dataclasses import dataclass

import numpy as np
from scipy import optimize, special, stats

DRAWS = 500
ITERATIONS = 40
SETTLED = 1e-9          # of the log likelihood per step: sigma stands to 1e-5 then
LARGEST_SIGMA = 30.0   # of the range of x: beyond it there is no slope to see
SMALLEST_SIGMA = 1e-3
TINY = 1e-12
QUARTILE = {'normal': 0.6744897501960817, 'logistic': 1.0986122886681098}   # F^-1(0.75)
SLOPE = {'normal': 0.3989422804014327, 'logistic': 0.25}                    # density at 0


@dataclass
class Fit:
    pse: float
    jnd: float
    slope: float
    sigma: float
    pse_interval: tuple
    jnd_interval: tuple
    trials: int
    deviance_p: float    # share of draws with a larger deviance
    shape: str


def cumulative(z, shape):
    return special.ndtr(z) if shape == 'normal' else special.expit(z)


def density(z, shape):
    if shape == 'normal':
        return np.exp(-0.5 * z * z) / np.sqrt(2 * np.pi)
    f = special.expit(z)
    return f * (1 - f)


def probability(x, mu, sigma, gamma, lapse, shape='normal'):
    return gamma + (1 - gamma - lapse) * cumulative((x - mu) / sigma, shape)


def loss(x, count, positive, mu, sigma, gamma, lapse, shape):
    """Negative log likelihood of each row of `positive`; mu, sigma one per row."""
    p = np.clip(probability(x, mu[:, None], sigma[:, None], gamma, lapse, shape), TINY, 1 - TINY)
    return -(positive * np.log(p) + (count - positive) * np.log1p(-p)).sum(axis=1)


def starts(x, count, positive):
    """Moments of the data: where half is positive, and how wide it rises."""
    share = (positive + 0.5) / (count + 1)
    z = special.ndtri(np.clip(share, 0.02, 0.98))
    weight = count / count.sum()
    mean_x, mean_z = (weight * x).sum(), (weight * z).sum(axis=1)
    slope = (weight * (x - mean_x) * (z - mean_z[:, None])).sum(axis=1) / max((weight * (x - mean_x) ** 2).sum(), TINY)
    spread = np.ptp(x) if np.ptp(x) > 0 else 1.0
    slope = np.maximum(slope, 1 / (10 * spread))
    return np.clip(mean_x - mean_z / slope, x.min() - spread, x.max() + spread), 1 / slope


def scoring_step(x, count, positive, mu, t, gamma, lapse, shape):
    """Fisher's step in mu and log sigma."""
    sigma = np.exp(t)
    z = (x - mu[:, None]) / sigma[:, None]
    p = np.clip(gamma + (1 - gamma - lapse) * cumulative(z, shape), TINY, 1 - TINY)
    slope = (1 - gamma - lapse) * density(z, shape)
    variance = p * (1 - p)
    weight, residual = count / variance, (positive - count * p) / variance
    d_mu, d_t = -slope / sigma[:, None], -slope * z
    g_mu, g_t = (residual * d_mu).sum(axis=1), (residual * d_t).sum(axis=1)
    a, b, c = (weight * d_mu ** 2).sum(axis=1) + TINY, (weight * d_mu * d_t).sum(axis=1), (weight * d_t ** 2).sum(axis=1) + 1e-9
    determinant = np.maximum(a * c - b * b, TINY)
    return (c * g_mu - b * g_t) / determinant, (a * g_t - b * g_mu) / determinant


def fit_many(x, count, positive, gamma, lapse, shape='normal'):
    """mu and sigma of each row of `positive` (n x levels). Fisher scoring with halved steps; rows that have settled are left alone."""
    x, count, positive = np.asarray(x, float), np.asarray(count, float), np.atleast_2d(np.asarray(positive, float))
    spread = np.ptp(x) if np.ptp(x) > 0 else 1.0
    positive, back = np.unique(positive, axis=0, return_inverse=True)
    mu, sigma = starts(x, count, positive)
    low, high = np.log(SMALLEST_SIGMA * spread), np.log(LARGEST_SIGMA * spread)
    t = np.clip(np.log(sigma), low, high)
    best = loss(x, count, positive, mu, np.exp(t), gamma, lapse, shape)
    open_rows = np.arange(len(mu))
    for _ in range(ITERATIONS):
        k, m, s = positive[open_rows], mu[open_rows], t[open_rows]
        step_mu, step_t = scoring_step(x, count, k, m, s, gamma, lapse, shape)
        step_mu, step_t = np.clip(step_mu, -spread, spread), np.clip(step_t, -1, 1)
        for _ in range(8):
            new_mu, new_t = m + step_mu, np.clip(s + step_t, low, high)
            value = loss(x, count, k, new_mu, np.exp(new_t), gamma, lapse, shape)
            worse = value > best[open_rows] + 1e-12
            if not worse.any():
                break
            step_mu, step_t = np.where(worse, 0.5 * step_mu, step_mu), np.where(worse, 0.5 * step_t, step_t)
        mu[open_rows], t[open_rows] = np.where(worse, m, new_mu), np.where(worse, s, new_t)
        gain = np.where(worse, 0.0, best[open_rows] - value)
        best[open_rows] -= gain
        open_rows = open_rows[gain > SETTLED]
        if not len(open_rows):
            break
    return mu[back.ravel()], np.exp(t)[back.ravel()]


def fit_one(x, count, positive, gamma, lapse, shape='normal'):
    """The same by scipy.optimize from several starts: slower, and the oracle of `fit_many`."""
    x, count, positive = (np.asarray(v, float) for v in (x, count, positive))
    spread = np.ptp(x) if np.ptp(x) > 0 else 1.0
    best = None
    for sigma in (0.05, 0.2, 1.0):
        start = np.array([float(np.average(x, weights=count)), np.log(sigma * spread)])
        found = optimize.minimize(lambda p: float(loss(x, count, positive[None], p[:1], np.exp(p[1:]), gamma, lapse, shape)[0]),
                                  start, method='Nelder-Mead',
                                  options={'xatol': 1e-9, 'fatol': 1e-12, 'maxiter': 4000,
                                           'initial_simplex': start + np.array([[0, 0], [0.1 * spread, 0], [0, 0.3]])})
        best = found if best is None or found.fun < best.fun else best
    return float(best.x[0]), float(np.exp(best.x[1]))


def deviance(count, positive, p):
    p = np.clip(p, TINY, 1 - TINY)
    return 2 * (special.xlogy(positive, positive / (count * p)) +
                special.xlogy(count - positive, (count - positive) / (count * (1 - p)))).sum(axis=-1)


def percentiles(draws, shift=0.0, level=0.95):
    low, high = np.quantile(draws, [0.5 * (1 - level), 0.5 * (1 + level)])
    return float(low + shift), float(high + shift)


def grouped(x, positive):
    """Levels, counts, positives of single trials."""
    levels, index = np.unique(np.round(np.asarray(x, float), 12), return_inverse=True)
    return levels, np.bincount(index).astype(float), np.bincount(index, weights=np.asarray(positive, float))


def fit(x, count, positive, gamma=0.0, lapse=0.0, shape='normal', draws=DRAWS, seed=1):
    """A Fit, or None where the data show no slope: one level, or all answers alike."""
    x, count, positive = (np.asarray(v, float) for v in (x, count, positive))
    if len(x) < 2 or positive.sum() in (0, count.sum()):
        return None
    mu, sigma = (v[0] for v in fit_many(x, count, positive, gamma, lapse, shape))
    random, observed = np.random.default_rng(seed), deviance(count, positive, probability(x, mu, sigma, gamma, lapse, shape))

    def draw(of_sigma, number):
        p = np.clip(probability(x, mu, of_sigma, gamma, lapse, shape), 0, 1)
        drawn = random.binomial(count.astype(int), p, size=(number, len(x)))
        return drawn, *fit_many(x, count, drawn, gamma, lapse, shape)

    # The likelihood's sigma is small by a few per cent: first how much, then intervals from draws of what is left without it.
    _, _, sigmas = draw(sigma, draws // 2)
    best = sigma * sigma / float(np.exp(np.median(np.log(sigmas))))
    drawn, mus, sigmas = draw(best, draws)
    low, high = percentiles(np.log(sigmas), np.log(best / sigma))
    drawn_p = probability(x, mus[:, None], sigmas[:, None], gamma, lapse, shape)
    quartile = QUARTILE[shape]
    return Fit(float(mu), float(quartile * best), float((1 - gamma - lapse) * SLOPE[shape] / best), float(best),
               percentiles(mus), (float(quartile * np.exp(low)), float(quartile * np.exp(high))), int(count.sum()),
               float((deviance(count, drawn, drawn_p) >= observed).mean()), shape)


def regression(x, y):
    """Slope, its standard error and p over trials: learning curves."""
    if len(x) < 3 or np.ptp(x) == 0:
        return float('nan'), float('nan'), float('nan')
    found = stats.linregress(x, y)
    return float(found.slope), float(found.stderr), float(found.pvalue)
