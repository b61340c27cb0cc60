/* Cubic B-splines at a place: their values, and how far the place is beyond the ends. `bends` of the
   knots are where pieces meet, after three below; returns the first of the four B-splines there. */
static int splines(real at, const real *knots, int bends, real *values, real *fade)
{
    const real low = knots[3], high = knots[bends + 2];
    const real below = low - at, above = at - high;
    const real away = below > above ? below : above;
    const real share = R(1.0) - (away > R(0.0) ? away : R(0.0)) / (FADES * (high - low));
    const real left_over = share > R(0.0) ? share : R(0.0);
    real left[PIECES - 1], right[PIECES - 1];
    int first = 0;
    *fade *= left_over * left_over * (R(3.0) - R(2.0) * left_over);
    at = at < low ? low : at > high ? high : at;
    for (int k = 1; k < bends - 1; ++k)
        first += at >= knots[3 + k];
    for (int n = 0; n < PIECES - 1; ++n) {
        left[n] = at - knots[first + 3 - n];
        right[n] = knots[first + 4 + n] - at;
    }
    values[0] = R(1.0);
    for (int degree = 1; degree < PIECES; ++degree) {
        real carried = R(0.0);
        for (int n = 0; n < degree; ++n) {
            const real part = values[n] / (right[n] + left[degree - 1 - n]);
            values[n] = carried + right[n] * part;
            carried = left[degree - 1 - n] * part;
        }
        values[degree] = carried;
    }
    return first;
}

/* A curve, N*m, over one coordinate, or over two, of which the second runs fastest in the heights;
   `more` is 0 without a second. */
static real over(real at, const real *knots, int bends, real other, const real *others, int more,
                 const real *heights)
{
    const int count = more > 0 ? PIECES : 1, row = more > 0 ? more + 2 : 1;
    real values[PIECES], second[PIECES] = {R(1.0)}, fade = R(1.0), sum = R(0.0);
    const int first = splines(at, knots, bends, values, &fade);
    const int column = more > 0 ? splines(other, others, more, second, &fade) : 0;
    for (int n = 0; n < PIECES; ++n)
        for (int k = 0; k < count; ++k)
            sum += values[n] * second[k] * heights[(first + n) * row + column + k];
    return fade * sum;
}
