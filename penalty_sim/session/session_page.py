"""One HTML file of a session: it asks for nothing from outside, and holds what its plots need."""
import html
import json
import os

import numpy as np

import session_data
import view_data
from session_series import Packed

HERE = os.path.dirname(os.path.abspath(__file__))
LANE_SPELLS = 1500       # spells of a lane that are kept apart; shorter ones are then drawn as "in turn"
LANES = 24               # pairs of links that have a lane; the table has all of them
ROWS = 400               # of a table
AXES = 'xyz'


def text(value):
    return html.escape(str(value))


class Panels:
    """What the page plots: panels of traces that point into the packed series."""

    def __init__(self, session, per_bin):
        self.session, self.table = session, session.table
        self.packed = Packed(len(self.table), per_bin)
        self.panels = []
        self.drawn = {}  # by hand: indices of the series that the 3-D view draws

    def panel(self, title, unit, note='', span=0.0, zero=False, log=False):
        """`span`: least height of the axis, so that noise does not look like a signal; `zero`: it shows 0; `log`: of decades."""
        self.panels.append({'title': title, 'unit': unit, 'note': note, 'span': span, 'zero': zero, 'log': log, 'traces': []})

    def trace(self, name, values, style, dash=0, shown=True):
        """`style`: colour of the page, 0 to 5; `dash`: 0 whole, 1 dashed, 2 dotted."""
        if np.isfinite(values).any():
            self.panels[-1]['traces'].append({'name': name, 'series': self.packed.add(values), 'style': style, 'dash': dash,
                                              'shown': shown})
            return self.packed.last
        return None

    def sparse(self, name, times, values, style, dash=0):
        self.panels[-1]['traces'].append({'name': name, 'style': style, 'dash': dash, 'shown': True,
                                          'x': [round(float(x), 4) for x in times], 'y': [float(f'{y:.5g}') for y in values]})

    def vector(self, label, name, factor, dash=0):
        return [self.trace(f'{label}{axis}', factor * self.table[f'{name}_{axis}'], style, dash) for style, axis in enumerate(AXES)]


def rotation_vectors(table, name):
    """Rotation vectors [rad], rows × 3, |v| <= pi, of the quaternion columns `name`."""
    q = np.stack([table[f'{name}_{axis}'] for axis in 'xyzw'], axis=1)
    q = np.where(q[:, 3:] < 0, -q, q)
    length = np.linalg.norm(q[:, :3], axis=1)
    small = length < 1e-12
    factor = np.where(small, 2.0, 2 * np.arctan2(length, q[:, 3]) / np.where(small, 1.0, length))
    return factor[:, None] * q[:, :3]


def add_hand(panels, hand, several):
    table, prefix = panels.table, (hand + ': ' if several else '')
    panels.panel(prefix + 'position of the grip', 'mm', 'in the device’s base', span=1)
    panels.vector('', hand + '.position', 1e3)
    panels.panel(prefix + 'orientation of the grip', '°', 'rotation vector in the device’s base', span=0.5)
    for style, (axis, values) in enumerate(zip(AXES, rotation_vectors(table, hand + '.orientation').T)):
        panels.trace(axis, np.degrees(values), style)
    panels.panel(prefix + 'velocity of the grip', 'mm/s', span=10, zero=True)
    panels.vector('', hand + '.linear', 1e3)
    for quantity, unit, factor, span in (('force', 'N', 1.0, 0.1), ('torque', 'mN·m', 1e3, 1.0)):
        panels.panel(f'{prefix}{quantity} on the hand', unit, 'dashed: asked by the loop; solid: what the strings give', span=span,
                     zero=True)
        asked = panels.vector('asked ', f'{hand}.asked_{quantity}', factor, dash=1)
        given = panels.vector('given ', f'{hand}.achieved_{quantity}', factor)
        if quantity == 'force':
            panels.drawn[hand] = {'asked': asked, 'force': given}
    panels.panel(prefix + 'tensions', 'N', span=0.1, zero=True)
    strings = sum(name.startswith(hand + '.tension_') for name in table.dtype.names)
    panels.drawn[hand]['tension'] = [panels.trace(f'string {string}', table[f'{hand}.tension_{string}'], string % 6, string // 6)
                                     for string in range(strings)]
    panels.panel(prefix + 'normal force on the pointer', 'N', 'sum over its contacts, in the world', span=0.1, zero=True)
    panels.trace('force', table[hand + '.contact_force'], 0)
    panels.panel(prefix + 'depth of the pointer’s contacts', 'mm', span=0.01, zero=True)
    panels.trace('depth', 1e3 * table[hand + '.contact_depth'], 1)
    panels.panel(prefix + 'energy at the port', 'mJ', 'absorbed by the loop; below zero it gave energy to the hand', span=1, zero=True)
    panels.trace('absorbed', 1e3 * table[hand + '.port_energy'], 0)
    panels.trace('dissipated by the passivity controller', 1e3 * table[hand + '.dissipated'], 1, 1)


def add_world(panels):
    table = panels.table
    panels.panel('energy of the world', 'mJ', span=0.1, zero=True)
    for style, name in enumerate(('kinetic', 'potential', 'elastic')):
        panels.trace(name, 1e3 * table['world.' + name], style)
    panels.panel('where energy came from and went', 'mJ', 'sums since the start; the balance is constant up to the step’s error',
                 span=0.1, zero=True)
    for style, (name, label) in enumerate((('external', 'work of hands and drives'), ('damping', 'damping'), ('friction', 'friction'),
                                           ('balance', 'balance'))):
        panels.trace(label, 1e3 * table['world.' + name], style)
    statistics = panels.session.statistics
    if statistics['time'].size:
        panels.panel('time of a tick', 'µs', 'ten times a second', log=True)
        for style, (name, label) in enumerate((('tick_us_p50', 'compute, median'), ('tick_us_p99', 'compute, 99 %'),
                                               ('tick_us_max', 'compute, greatest'), ('lateness_us_p50', 'lateness, median'),
                                               ('lateness_us_p99', 'lateness, 99 %'))):
            panels.sparse(label, statistics['time'], statistics[name], style, int(style > 2))
        ends, period = (0, len(table) / panels.session.info['rate']), 1e6 / panels.session.info['rate']
        panels.sparse('period', ends, (period, period), 5, 2)


def merged(spells, duration):
    """Where a lane has too many spells, those too short to be seen become 'turn': stick and slip in turn."""
    if len(spells) <= LANE_SPELLS:
        return spells
    shortest, out = duration / LANE_SPELLS, []
    for begin, end, kind in spells:
        if out and end - out[-1][0] < shortest:
            out[-1] = (out[-1][0], end, kind if kind == out[-1][2] else 'turn')
        else:
            out.append((begin, end, kind))
    return out


def lanes(session, duration):
    """Strips of what held from when to when: contacts of pairs, states and limits of devices."""
    out, pairs = [], {}
    for spell in session.spells:
        pairs.setdefault((spell['link_a'], spell['link_b']), []).append((spell['begin'], spell['end'], spell['state']))
    longest = sorted(pairs, key=lambda pair: -sum(end - begin for begin, end, _ in pairs[pair]))[:LANES]
    for pair in longest:
        out.append({'group': 'contact', 'name': ' – '.join(pair), 'spells': merged(pairs[pair], duration)})
    times, period = session.table['time'], 1 / session.info['rate']
    for hand in session.hands():
        states = session.table[hand + '.state']
        spells = [(begin, end, name) for value, name in enumerate(session_data.STATES)
                  for begin, end in session_data.spells_of(states == value, times, period)]
        out.append({'group': 'state', 'name': hand, 'spells': sorted(spells)})
        for flag, found in session_data.flag_spells(session, hand).items():
            out.append({'group': 'limit', 'name': f'{hand}: {session_data.FLAG_WORDS[flag]}',
                        'spells': merged([(*s, 'fault' if flag in session_data.FAULTS else 'limit') for s in found], duration)})
    stopped = session_data.spells_of(session.table['world.stopped'] != 0, times, period)
    if stopped:
        out.append({'group': 'limit', 'name': 'the world stopped: a number was lost', 'spells': [(*s, 'fault') for s in stopped]})
    return [{**lane, 'spells': [(round(b, 4), round(e, 4), k) for b, e, k in lane['spells']]} for lane in out], len(pairs) - len(longest)


def table(heads, rows):
    body = ''.join('<tr>' + ''.join(f'<td class="{"number" if isinstance(cell, float) else "text"}">'
                                    f'{f"{cell:.4g}" if isinstance(cell, float) else text(cell)}</td>' for cell in row) + '</tr>'
                   for row in rows[:ROWS])
    more = f'<p class="note">{len(rows) - ROWS} more rows are in the file of <code>./run export</code>.</p>' if len(rows) > ROWS else ''
    kinds = ['number' if rows and isinstance(cell, float) else 'text' for cell in (rows[0] if rows else heads)]
    head = ''.join(f'<th class="{kind}" scope="col">{text(h)}</th>' for h, kind in zip(heads, kinds))
    return f'<div class="table"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>{more}'


def details(title, body, is_open=False):
    return f'<details{" open" if is_open else ""}><summary>{text(title)}</summary>{body}</details>'


def contact_table(session):
    pairs = {}
    for spell in session.spells:
        pairs.setdefault((spell['link_a'], spell['link_b']), []).append(spell)
    rows = []
    for (a, b), spells in pairs.items():
        touching = sum(s['end'] - s['begin'] for s in spells)
        sticking = sum(s['end'] - s['begin'] for s in spells if s['state'] == 'stick')
        rows.append([f'{a} – {b}', touching, 100 * sticking / touching if touching else 0.0, float(len(spells)),
                     max(s['peak_force'] for s in spells), 1e3 * max(s['peak_depth'] for s in spells)])
    return table(['links', 'touching [s]', 'of it sticking [%]', 'spells', 'greatest normal force [N]', 'greatest depth [mm]'],
                 sorted(rows, key=lambda row: -row[1]))


def fault_table(session):
    rows = []
    for hand in session.hands():
        for flag, spells in session_data.flag_spells(session, hand).items():
            rows.append([session_data.FLAG_WORDS[flag], hand, spells[0][0], sum(e - b for b, e in spells), float(len(spells))])
    return table(['limit or fault', 'device', 'first at [s]', 'lasted, in all [s]', 'times'], rows) if rows else \
        '<p>No limit acted and no fault was seen.</p>'


def cards(session, duration):
    hands, shown = session.hands(), []
    shown.append((f'{duration:.4g} s', f'{len(session.table)} ticks at {session.info["rate"]:.0f} Hz'))
    for hand in hands:
        force = np.sqrt(sum(session.table[f'{hand}.achieved_force_{axis}'] ** 2 for axis in AXES))
        name = f' ({hand})' if len(hands) > 1 else ''
        shown.append((f'{np.nanmax(force):.3g} N' if np.isfinite(force).any() else '–', 'greatest force on the hand' + name))
        shown.append((f'{100 * np.nanmean(session.table[hand + ".contact"] > 0):.3g} %', 'of the time in contact' + name))
    lost = int(np.nansum(session.table['lost_periods']))
    shown.append((str(lost), 'tick lost' if lost == 1 else 'ticks lost'))
    faults = sum(len(session_data.spells_of(session.table[hand + '.state'] == 4, session.table['time'], 0)) for hand in hands)
    shown.append((str(faults), 'fault' if faults == 1 else 'faults'))
    return ''.join(f'<div><b>{text(value)}</b>{text(label)}</div>' for value, label in shown)


def provenance(session, bag):
    info = session.info
    devices = ', '.join(f'{hand["name"]} ({hand["model"]}, {hand["strings"]} strings)' for hand in info['hands'])
    if not info['compared']:
        check = 'The recording has no hashes to check this replay with.'
    elif info['mismatches']:
        check = (f'<b>{info["mismatches"]} of {info["compared"]} ticks differ from the recording</b>, first '
                 f'{text(info["first_difference"])} at {info["first_difference_time"]:.3f} s: poses and counts are the recording’s, '
                 'forces and contacts after that are those of this build.')
    else:
        check = 'The replay gave the same bits in every tick.'
    return (f'<p>Scene <b>{text(info["scene"])}</b>, {"devices" if len(info["hands"]) > 1 else "device"} {text(devices)}; '
            f'{text(os.path.basename(bag))}, {text(info["program"])}, {text(info["build"])}.</p><p class="note">Every tick was '
            f'computed again from the encoder counts of the recording. {check}</p>')


def section(session, bag, number, per_bin, packed_view, no_view):
    """`packed_view`: of view_data.pack, None: the page has no picture and says `no_view`."""
    duration = len(session.table) / session.info['rate']
    panels = Panels(session, per_bin)
    for hand in session.hands():
        add_hand(panels, hand, len(session.hands()) > 1)
    add_world(panels)
    strips, left_out = lanes(session, duration)
    data = {'duration': duration, 'period': per_bin / session.info['rate'], 'points': panels.packed.points, 'bin': per_bin,
            'ranges': panels.packed.ranges, 'panels': panels.panels, 'lanes': strips, 'tick': 1 / session.info['rate'],
            'missed': [round(float(at), 4) for at in session.table['time'][session.table['lost_periods'] > 0][:LANE_SPELLS]],
            'view': packed_view and {**packed_view[0], 'drawn': [panels.drawn[hand] for hand in session.hands()]}, 'noView': no_view,
            'events': [[round(float(at), 4), name] for at, name, _ in session.info['events']]}
    note = f'<p class="note">{left_out} more pairs of links touched; the table has them.</p>' if left_out else ''
    about = json.dumps(data, separators=(',', ':')).replace('</', '<\\/')
    messages = table(['at [s]', 'device', 'state', 'message'], [[float(t), d, s, m] for t, d, s, m in session.messages])
    return (f'<section class="session" data-session="{number}">{provenance(session, bag)}<div class="cards">{cards(session, duration)}'
            f'</div><div class="plots"></div>{note}{details("Contacts of each pair of links", contact_table(session), True)}'
            f'{details("Limits and faults", fault_table(session), True)}{details("What devices said", messages)}'
            f'<script type="application/json">{about}</script>'
            f'<script type="text/plain">{panels.packed.text()}</script>'
            + (f'<script type="text/plain">{packed_view[1]}</script>' if packed_view else '') + '</section>')


def read_here(name):
    with open(os.path.join(HERE, name), encoding='utf-8') as file:
        return file.read()


def document(sessions, bag, per_bin=1, views=(), program='', no_view=''):
    """The page; each point of its plots is a bin of `per_bin` ticks. `views`: view_data.pack of each session; `program`: of view_program;
    `no_view`: why there is none."""
    title = 'Session: ' + ', '.join(dict.fromkeys(session.info['scene'] for session in sessions))
    parts = [section(session, bag, number, per_bin, views[number] if views else None, no_view) for number, session in enumerate(sessions)]
    several = [f'<h2>Part {number + 1} of {len(parts)}</h2>{part}' if len(parts) > 1 else part for number, part in enumerate(parts)]
    return (f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, '
            f'initial-scale=1"><title>{text(title)}</title><style>{read_here("session_page.css")}</style></head><body>'
            f'<button id="theme" type="button">light / dark</button><h1>{text(title)}</h1><noscript><p>The plots are drawn by a '
            f'script in this file; the tables below are not.</p></noscript>{"".join(several)}'
            + (f'<script type="text/plain" id="view3d">{program}</script>' if program else '') +
            f'<script>{read_here("session_time.js")}{read_here("session_page.js")}</script></body></html>\n')
