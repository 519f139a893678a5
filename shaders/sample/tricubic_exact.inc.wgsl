// The cubic B-spline by eight fetches, each computed. Twin of sample::Sampler::TricubicExact.
#import fetch/exact
#import shared/bspline
