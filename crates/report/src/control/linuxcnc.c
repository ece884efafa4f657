/* How the tool deviates from the table by the errors of all joints, and what the linear axes do against it.
 *
 * d(p) = R delta + (R omega) x (p - o) at every joint; deviation = sum over the tool side - sum over the table side.
 * R, o: nominal axes and origin of the joint in the machine; p: tool point in the machine; delta, omega: error of the joint.
 * The linear axes move by the opposite of the deviation. Positions: mm and degrees; errors: mm and rad. */

struct pose { double turn[3][3], at[3]; };

static void times(double out[3], double m[3][3], const double v[3])
{
    int i;
    for (i = 0; i < 3; i++) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Right-handed turn about a unit vector. */
static void turned(double out[3][3], const double about[3], double angle)
{
    double c = cos(angle), s = sin(angle);
    int i, j;
    for (i = 0; i < 3; i++)
        for (j = 0; j < 3; j++) out[i][j] = about[i] * about[j] * (1.0 - c) + (i == j ? c : 0.0);
    out[0][1] -= about[2] * s;
    out[1][0] += about[2] * s;
    out[0][2] += about[1] * s;
    out[2][0] -= about[1] * s;
    out[1][2] -= about[0] * s;
    out[2][1] += about[0] * s;
}

/* Error of a joint: its location, and straight lines between the rows of its table; beyond them the nearest row. */
static void error_at(const struct joint *joint, double position, double error[6])
{
    double place, share;
    int k, row;
    for (k = 0; k < 6; k++) error[k] = joint->location[k];
    if (joint->rows < 2) return;
    if (joint->whole_turn) {
        double turn = joint->last - joint->first;
        position -= turn * floor((position - joint->first) / turn);
    }
    place = (position - joint->first) / (joint->last - joint->first) * (joint->rows - 1);
    if (place < 0.0) place = 0.0;
    if (place > joint->rows - 1) place = joint->rows - 1;
    row = (int)place;
    if (row > joint->rows - 2) row = joint->rows - 2;
    share = place - row;
    for (k = 0; k < 6; k++)
        error[k] += joint->errors[row][k] * (1.0 - share) + joint->errors[row + 1][k] * share;
}

/* Travel of the first three linear joints against the deviation; 0 where they cannot move the tool in all directions. */
static int correction(const double position[JOINTS], const double tool[3], double travel[3])
{
    struct pose side[2];
    double turn[JOINTS][3][3], origin[JOINTS][3], along[3][3], deviation[3] = { 0, 0, 0 };
    double point[3], about[3], volume;
    int linear = 0, i, k, n;
    for (k = 0; k < 2; k++)
        for (i = 0; i < 3; i++) {
            side[k].at[i] = 0.0;
            for (n = 0; n < 3; n++) side[k].turn[i][n] = i == n ? 1.0 : 0.0;
        }
    for (n = 0; n < JOINTS; n++) {
        const struct joint *joint = &joints[n];
        struct pose *carrier = &side[joint->tool_side];
        double travelled = position[n] * joint->sense, here[3], moved[3], direction[3];
        for (i = 0; i < 3; i++)
            for (k = 0; k < 3; k++) turn[n][i][k] = carrier->turn[i][k];
        for (i = 0; i < 3; i++)
            here[i] = joint->rotary ? joint->through[i] : joint->direction[i] * travelled;
        times(moved, carrier->turn, here);
        for (i = 0; i < 3; i++) origin[n][i] = moved[i] + carrier->at[i];
        times(direction, carrier->turn, joint->direction);
        if (joint->rotary) {
            double motion[3][3], carried[3][3], back[3];
            turned(motion, joint->direction, travelled * M_PI / 180.0);
            for (i = 0; i < 3; i++)
                for (k = 0; k < 3; k++)
                    carried[i][k] = carrier->turn[i][0] * motion[0][k] + carrier->turn[i][1] * motion[1][k]
                                  + carrier->turn[i][2] * motion[2][k];
            times(back, carried, joint->through);
            for (i = 0; i < 3; i++) {
                carrier->at[i] = origin[n][i] - back[i];
                for (k = 0; k < 3; k++) carrier->turn[i][k] = carried[i][k];
            }
        } else {
            for (i = 0; i < 3; i++) carrier->at[i] = origin[n][i];
            if (linear < 3) {
                double towards = joint->sense * (joint->tool_side ? 1.0 : -1.0);
                for (i = 0; i < 3; i++) along[linear][i] = direction[i] * towards;
            }
            linear++;
        }
    }
    times(point, side[1].turn, tool);
    for (i = 0; i < 3; i++) point[i] += side[1].at[i];
    for (n = 0; n < JOINTS; n++) {
        double error[6], shift[3], tilt[3], arm[3], swing[3], sign = joints[n].tool_side ? 1.0 : -1.0;
        error_at(&joints[n], position[n], error);
        times(shift, turn[n], error);
        times(tilt, turn[n], error + 3);
        for (i = 0; i < 3; i++) arm[i] = point[i] - origin[n][i];
        cross(swing, tilt, arm);
        for (i = 0; i < 3; i++) deviation[i] += sign * (shift[i] + swing[i]);
    }
    if (linear < 3) return 0;
    cross(about, along[1], along[2]);
    volume = dot(along[0], about);
    if (fabs(volume) < 1e-6) return 0;
    for (n = 0; n < 3; n++) {
        cross(about, along[(n + 1) % 3], along[(n + 2) % 3]);
        travel[n] = SIGN * dot(deviation, about) / volume;
    }
    return 1;
}
