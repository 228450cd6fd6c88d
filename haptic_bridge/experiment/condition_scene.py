"""A condition as a scene file: the study's URDF with the values that differ. The loop loads it as it loads any scene, and a recording
holds its whole text."""
import hashlib
import os
import re
import xml.etree.ElementTree as xml

from strict_yaml import Refused

HERE = os.path.dirname(os.path.abspath(__file__))
SPACE = 'https://haptic/urdf'
CONTACT = {'stiffness': 'stiffness', 'young_modulus': 'young_modulus', 'damping': 'damping', 'dissipation': 'dissipation'}
FRICTION = ('mu_static', 'mu_dynamic')
HOW_STIFF = ('stiffness', 'young_modulus', 'material')  # a contact says one of them
OF_POINTER = {'coupling': 'coupling', 'coupling_stiffness': 'stiffness', 'pose_delay': 'pose_delay', 'force_delay': 'force_delay'}
OF_LINKS = set(CONTACT) | {'friction', 'mass', 'shown', 'seen_offset'}
xml.register_namespace('haptic', SPACE)


def tag(name):
    return f'{{{SPACE}}}{name}'


def number(value):
    return repr(float(value))


def contact_of(collision):
    found = collision.find(tag('contact'))
    return xml.SubElement(collision, tag('contact')) if found is None else found


def change_contact(link, name, value):
    for collision in link.findall('collision'):
        contact = contact_of(collision)
        if name == 'friction':
            for each in FRICTION:
                contact.set(each, number(value))
            continue
        if name in HOW_STIFF:
            for other in HOW_STIFF:
                contact.attrib.pop(other, None)
        contact.set(CONTACT[name], number(value))


def change_mass(path, link, value):
    mass = link.find('inertial/mass')
    if mass is None:
        raise Refused(f"{path}: link {link.get('name')} has no mass to change; give it an <inertial>")
    share = value / float(mass.get('value'))
    mass.set('value', number(value))
    inertia = link.find('inertial/inertia')
    for key in inertia.attrib if inertia is not None else ():
        inertia.set(key, number(share * float(inertia.get(key))))


def change_sight(link, name, value):
    """What is seen is the visual, what is felt the collision: they may differ."""
    for visual in link.findall('visual'):
        if name == 'shown' and value == 'false':
            material = visual.find('material')
            if material is None:
                material = xml.SubElement(visual, 'material', name=f"hidden_{link.get('name')}")
            color = material.find('color')
            if color is None:
                color = xml.SubElement(material, 'color', rgba='0.5 0.5 0.5 1')
            color.set('rgba', ' '.join(color.get('rgba').split()[:3] + ['0']))
        if name == 'seen_offset':
            origin = visual.find('origin')
            if origin is None:
                origin = xml.Element('origin')
                visual.insert(0, origin)
            xyz = [float(v) for v in origin.get('xyz', '0 0 0').split()]
            origin.set('xyz', ' '.join(number(v) for v in (xyz[0], xyz[1], xyz[2] + value)))


def change(path, root, target, name, value):
    if name in OF_LINKS:
        links = [link for link in root.findall('link') if link.get('name') in target]
        for word in set(target) - {link.get('name') for link in links}:
            raise Refused(f"{path}: has no link '{word}'; there are {', '.join(link.get('name') for link in root.findall('link'))}")
        for link in links:
            if name == 'mass':
                change_mass(path, link, value)
            elif name in ('shown', 'seen_offset'):
                change_sight(link, name, value)
            else:
                change_contact(link, name, value)
    elif name == 'gravity':
        scene_tag(root).set('gravity', f'0 0 {number(-value)}')
    elif name in OF_POINTER:
        pointer = root.find(tag('pointer'))
        if pointer is None:
            raise Refused(f'{path}: names no haptic:pointer, whose {name} could change')
        pointer.set(OF_POINTER[name], value if isinstance(value, str) else number(value))


def scene_tag(root):
    found = root.find(tag('scene'))
    if found is None:
        found = xml.Element(tag('scene'))
        root.insert(0, found)
    return found


def changed_text(path, text, target, condition):
    """The URDF `text` under `condition`. Raises Refused."""
    try:
        root = xml.fromstring(text)
    except xml.ParseError as error:
        raise Refused(f'{path}: is no XML: {error}') from error
    for name in ('pose_delay', 'force_delay'):
        if any(pointer.get(name) for pointer in root.iter(tag('pointer'))):
            raise Refused(f'{path}: haptic:pointer has a {name} of its own; give it to the conditions, whose rows say it')
    for name, value in condition.items():
        change(path, root, target, name, value)
    if 'rate' in condition:
        scene_tag(root).set('step', number(1 / condition['rate']))
    return xml.tostring(root, encoding='unicode') + '\n'


def write(study, condition, folder):
    """Path of the condition's scene below `folder`, written once; meshes keep the paths that they have as seen from the study's scene."""
    path = condition.get('scene', study.scene)
    try:
        with open(path, encoding='utf-8') as file:
            text = file.read()
    except OSError as error:
        raise Refused(f'{path}: cannot be read: {error.strerror}') from error
    here = os.path.dirname(os.path.abspath(path))
    text = re.sub(r'(<mesh\b[^>]*\bfilename=")(?![a-z]+://|/)', lambda m: m.group(1) + here + '/', text)
    changed = changed_text(path, text, study.target, {'rate': study.rate, **condition})
    stem = os.path.splitext(os.path.basename(path))[0]
    out = os.path.join(folder, f'{stem}-{hashlib.sha256(changed.encode()).hexdigest()[:10]}.urdf')
    if not os.path.exists(out):
        with open(out + '.part', 'w', encoding='utf-8') as file:
            file.write(changed)
            file.flush()
            os.fsync(file.fileno())
        os.replace(out + '.part', out)
    return out
