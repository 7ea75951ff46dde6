!> Coefficients of Radau IIA of order 5. Floor: integrator. Source: Hairer and Wanner, Solving Ordinary Differential Equations II,
!> sections IV.5 and IV.8; doc/theory, eqs. (5.6)-(5.8).
module limber_integrator_radau_method
   use limber_base_kinds, only: wp
   implicit none
   private

   real(wp), parameter :: root6 = sqrt(6.0_wp)
   !> Coefficients of the method; its nodes are the row sums
   real(wp), parameter, public :: radau_a(3, 3) = reshape([ &
      & (88 - 7*root6)/360, (296 + 169*root6)/1800, (16 - root6)/36, &
      & (296 - 169*root6)/1800, (88 + 7*root6)/360, (16 + root6)/36, &
      & (-2 + 3*root6)/225, (-2 - 3*root6)/225, 1.0_wp/9], [3, 3])
   real(wp), parameter, public :: radau_c(3) = [(4 - root6)/10, (4 + root6)/10, 1.0_wp]
   !> Real eigenvalue gamma and the pair of complex ones, alpha +- i beta, of the inverse of A
   real(wp), parameter :: third = 9.0_wp**(1.0_wp/3.0_wp)
   real(wp), parameter, public :: radau_gamma = 30/(6 + third*(third - 1))
   real(wp), parameter :: a0 = (12 - third*(third - 1))/60, b0 = third*(third + 1)*sqrt(3.0_wp)/60
   real(wp), parameter, public :: radau_alpha = a0/(a0**2 + b0**2), radau_beta = b0/(a0**2 + b0**2)
   !> Transformation that makes the inverse of A block diagonal, and its inverse
   real(wp), parameter, public :: radau_t(3, 3) = reshape([ &
      & 9.1232394870892942792e-2_wp, 0.24171793270710701896_wp, 0.96604818261509293619_wp, &
      & -0.14125529502095420843_wp, 0.20412935229379993199_wp, 1.0_wp, &
      & -3.0029194105147424492e-2_wp, 0.38294211275726193779_wp, 0.0_wp], [3, 3])
   real(wp), parameter, public :: radau_ti(3, 3) = reshape([ &
      & 4.3255798900631553510_wp, -4.1787185915519047273_wp, -0.50287263494578687595_wp, &
      & 0.33919925181580986954_wp, -0.32768282076106238708_wp, 2.5719269498556054292_wp, &
      & 0.54177053993587487119_wp, 0.47662355450055045196_wp, -0.59603920482822492497_wp], [3, 3])
   real(wp), parameter, public :: radau_lambda(3, 3) = reshape([ &
      & radau_gamma, 0.0_wp, 0.0_wp, 0.0_wp, radau_alpha, radau_beta, 0.0_wp, -radau_beta, radau_alpha], [3, 3])
   !> Inverse of A
   real(wp), parameter, public :: radau_inverse(3, 3) = matmul(radau_t, matmul(radau_lambda, radau_ti))
   !> Weights of the stages in the error estimate
   real(wp), parameter, public :: radau_weights(3) = [-(13 + 7*root6)/3, (-13 + 7*root6)/3, -1.0_wp/3]

end module limber_integrator_radau_method
