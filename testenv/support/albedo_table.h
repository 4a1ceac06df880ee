// The albedo that each inversion obtains on an index-matched half-space, from a computation independent of the renderer
// (Chandrasekhar's H by tanh-sinh quadrature, printed to five digits).
#pragma once

namespace alabaster::testing {

struct AlbedoRow {
  double albedo;                 // requested
  double exact_one_minus_alpha;  // 1 - alpha that obtains it
  double chiang2016;             // obtained with the paper's eq. 1
  double van_de_hulst_error;     // obtained minus requested
};

inline constexpr AlbedoRow kAlbedoTable[] = {
    {0.01, .952439, .01040, .00030},    {0.05, .785898, .05164, .00118},    {0.10, .620913, .10236, .00178},
    {0.15, .492053, .15232, .00203},    {0.20, .390325, .20175, .00205},    {0.25, .309341, .25095, .00192},
    {0.30, .244463, .30022, .00172},    {0.35, .192254, .34983, .00148},    {0.40, .150129, .39996, .00123},
    {0.45, .116109, .45070, .00098},    {0.50, .0886639, .50197, .00076},   {0.55, .0665929, .55352, .00056},
    {0.60, .0489457, .60494, .00040},   {0.65, .0349624, .65562, .00026},   {0.70, .0240299, .70482, .00016},
    {0.75, .0156501, .75170, .00009},   {0.80, .00941522, .79541, .00004},  {0.85, .00498904, .83519, .00001},
    {0.90, .00209298, .87041, .000002}, {0.95, 4.9482e-4, .90071, .000004}, {0.99, 1.895e-5, .92133, .000010},
    {0.999, 1.88e-7, .92553, .000012},  {1.0, 0, .92599, -.000012},
};

}  // namespace alabaster::testing
