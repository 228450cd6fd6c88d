"""read_parameter.py MASTER PARAMETER FILE: a text of a parameter server into a file. One line on stderr, and code 1, where it cannot be."""
import socket
import sys
import xmlrpc.client

PATIENCE = 5  # [s] for a master that does not answer


def main():
    master, parameter, path = sys.argv[1:]
    socket.setdefaulttimeout(PATIENCE)
    try:
        code, message, text = xmlrpc.client.ServerProxy(master).getParam('/demo', parameter)
    except (OSError, xmlrpc.client.Error) as error:
        sys.exit(f'no parameter server answers at {master} ({error}); start roscore, load the robot, or set ROS_MASTER_URI')
    if code != 1:
        sys.exit(f"{message} at {master}; load the robot's launch file first: rosparam list")
    if not isinstance(text, str):
        sys.exit('the parameter is no text; name one that holds a URDF')
    with open(path, 'w', encoding='utf-8') as file:
        file.write(text)


if __name__ == '__main__':
    main()
