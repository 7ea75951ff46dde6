!> Section angle of a taut exact beam from the forces in it. What the functions of the angle lack bends the beam, and the tension
!> resists that; the bending moment that equilibrium at the place of the functions asks for errs by the tension times what they
!> lack. Both follow from one equation along the axis, solved with polynomials of eighth degree in each panel. Floor: beam.
!> Source: doc/theory, eqs. (2.63), (2.64).
module limber_beam_taut_axis
   use limber_base_kinds, only: wp
   use limber_beam_exact_beam, only: exact_type, panel_stations, gauss_place, gauss_weight
   use limber_beam_exact_functions, only: legendre
   use limber_beam_exact_profile, only: of_ei
   implicit none
   private
   public :: settled_type, settle_axis, added_moment, added_angle, tensions, is_taut, locate, fields_at, values_at, fields

   !> Tension from which on it counts, in units of E I/L^2
   real(wp), parameter :: taut = 20.0_wp
   !> Stiffness against rotations that nothing else resists, in the same units
   real(wp), parameter :: nearly_nothing = 1.0e-7_wp
   !> Functions of a panel: two that are 1 at an end, and bubbles
   integer, parameter :: nodes = 2, fields = panel_stations + 1

   !> What the tension makes of curvatures that the functions lack
   type :: settled_type
      !> Coordinates of the rotation of the sections in the fields of each panel (fields, panels) [rad]; moment that comes to that
      !> by equilibrium (stations) [force length]
      real(wp), allocatable :: turn(:, :), moment(:)
      !> Moments of the polynomials at ends where there is none; lengths of the panels there in layers
      real(wp) :: over(2) = 0.0_wp, layers(2) = 0.0_wp
   end type settled_type

contains

   !> Tension that resists rotations of the sections, without the part that counts as none (stations) [force].
   pure function tensions(exact, eta, forces) result(tension)
      type(exact_type), intent(in) :: exact
      !> Coordinates (n); axial force, shear force, bending moment (3, stations)
      real(wp), intent(in) :: eta(:), forces(:, :)
      real(wp) :: tension(exact%stations)
      integer :: k
      associate (a => exact%angles)
         do k = 1, exact%stations
            tension(k) = (1 + dot_product(exact%chi(1, :, k), eta(a + 1:)))*forces(1, k) &
               & + dot_product(exact%chi(2, :, k), eta(a + 1:))*forces(2, k)
            tension(k) = max(0.0_wp, tension(k) - taut*exact%section(of_ei, k)/exact%total**2)
         end do
      end associate
   end function tensions

   !> Whether there is any.
   pure logical function is_taut(tension)
      !> (stations)
      real(wp), intent(in) :: tension(:)
      is_taut = any(tension > 0.0_wp)
   end function is_taut

   !> Rotation of the sections that curvatures make which the functions lack, against the tension, and the moment that it adds to
   !> that by equilibrium, eqs. (2.63), (2.64).
   pure subroutine settle_axis(exact, lack, tension, held, settled)
      type(exact_type), intent(in) :: exact
      !> Curvature by equilibrium less that of the functions (stations) [1/length], and tension (stations) [force]
      real(wp), intent(in) :: lack(:), tension(:)
      !> Whether the angle at the start, and at the end, is right; else the moment is
      logical, intent(in) :: held(2)
      type(settled_type), intent(out) :: settled
      real(wp), dimension(fields, panel_stations) :: value, slope
      real(wp) :: matrix(fields, fields, size(exact%panel)), load(fields, size(exact%panel))
      real(wp) :: diagonal(0:size(exact%panel)), beside(0:size(exact%panel)), side(0:size(exact%panel))
      integer :: p, m
      do m = 1, panel_stations
         value(:, m) = fields_at(gauss_place(m))
         slope(:, m) = [-0.5_wp, 0.5_wp, legendre([(p, p=1, fields - nodes)], gauss_place(m))]
      end do
      diagonal = 0.0_wp
      beside = 0.0_wp
      side = 0.0_wp
      do p = 1, size(exact%panel)
         call panel_matrix(exact, p, lack, tension, value, slope, matrix(:, :, p), load(:, p))
         diagonal(p - 1) = diagonal(p - 1) + matrix(1, 1, p)
         diagonal(p) = diagonal(p) + matrix(2, 2, p)
         beside(p - 1) = matrix(2, 1, p)
         side(p - 1:p) = side(p - 1:p) + load(:nodes, p)
      end do
      if (held(1)) call hold(0, beside, side)
      if (held(2)) call hold(size(exact%panel), beside, side)
      call solve_nodes(diagonal, beside, side)
      allocate (settled%turn(fields, size(exact%panel)))
      do p = 1, size(exact%panel)
         settled%turn(:nodes, p) = side(p - 1:p)
         do m = nodes + 1, fields
            settled%turn(m, p) = (load(m, p) - dot_product(matrix(:m - 1, m, p), settled%turn(:m - 1, p)))/matrix(m, m, p)
         end do
      end do
      call find_moments(exact, lack, tension, held, slope, settled)
   end subroutine settle_axis

   !> Moments from the curvatures, and what is to be taken from them near ends where there shall be none.
   pure subroutine find_moments(exact, lack, tension, held, slope, settled)
      type(exact_type), intent(in) :: exact
      !> As in `settle_axis`
      real(wp), intent(in) :: lack(:), tension(:)
      logical, intent(in) :: held(2)
      !> Slopes of the fields (fields, stations of a panel)
      real(wp), intent(in) :: slope(:, :)
      type(settled_type), intent(inout) :: settled
      integer :: p, side, first
      allocate (settled%moment(exact%stations))
      do p = 1, size(exact%panel)
         first = panel_stations*(p - 1)
         settled%moment(first + 1:first + panel_stations) = exact%section(of_ei, first + 1:first + panel_stations) &
            & *(matmul(settled%turn(:, p), slope)*2/exact%panel(p) - lack(first + 1:first + panel_stations))
      end do
      do side = 1, 2
         if (held(side)) cycle
         p = merge(1, size(exact%panel), side == 1)
         first = panel_stations*(p - 1)
         settled%over(side) = dot_product(values_at(real(2*side - 3, wp)), settled%moment(first + 1:first + panel_stations))
         settled%layers(side) = 0.5_wp*exact%panel(p)*sum(gauss_weight*sqrt(tension(first + 1:first + panel_stations) &
            & /exact%section(of_ei, first + 1:first + panel_stations)))
      end do
   end subroutine find_moments

   !> Moment at a place of a panel that comes to that by equilibrium. At ends where there is none it vanishes to round-off: what the
   !> polynomials have there is taken off within a layer.
   pure real(wp) function added_moment(settled, panel, x, row) result(moment)
      type(settled_type), intent(in) :: settled
      integer, intent(in) :: panel
      !> From -1 to 1; what the stations of the panel give to values there, see `values_at`
      real(wp), intent(in) :: x, row(:)
      moment = dot_product(row, settled%moment(panel_stations*(panel - 1) + 1:panel_stations*panel))
      if (panel == 1) moment = moment - settled%over(1)*0.5_wp*(1 - x)*exp(-0.5_wp*settled%layers(1)*(1 + x))
      if (panel == size(settled%turn, 2)) moment = moment - settled%over(2)*0.5_wp*(1 + x)*exp(-0.5_wp*settled%layers(2)*(1 - x))
   end function added_moment

   !> Rotation at a place of a panel [rad].
   pure real(wp) function added_angle(settled, panel, row) result(angle)
      type(settled_type), intent(in) :: settled
      integer, intent(in) :: panel
      !> Its fields there, see `fields_at`
      real(wp), intent(in) :: row(:)
      angle = dot_product(row, settled%turn(:, panel))
   end function added_angle

   !> Functions of a panel at a place of it (-1..1): straight lines, then integrals of Legendre's polynomials (fields).
   pure function fields_at(x) result(value)
      real(wp), intent(in) :: x
      real(wp) :: value(fields)
      integer :: k
      value(:nodes) = [0.5_wp*(1 - x), 0.5_wp*(1 + x)]
      do k = 1, fields - nodes
         value(nodes + k) = (legendre(k + 1, x) - legendre(k - 1, x))/(2*k + 1)
      end do
   end function fields_at

   !> What the stations of a panel give to the value of a field at a place of it (-1..1) (stations of a panel).
   pure function values_at(x) result(row)
      real(wp), intent(in) :: x
      real(wp) :: row(panel_stations)
      integer :: k
      row = 0.0_wp
      do k = 0, panel_stations - 1
         row = row + 0.5_wp*(2*k + 1)*gauss_weight*legendre(k, gauss_place)*legendre(k, x)
      end do
   end function values_at

   !> The panel of a place, and where it is there.
   pure subroutine locate(exact, place, behind, panel, x)
      type(exact_type), intent(in) :: exact
      !> [length]
      real(wp), intent(in) :: place
      !> Of a place between two panels: whether it belongs to the one behind it
      logical, intent(in) :: behind
      integer, intent(out) :: panel
      !> From -1 to 1
      real(wp), intent(out) :: x
      real(wp) :: from
      real(wp), parameter :: same = 1.0e-9_wp
      from = 0.0_wp
      do panel = 1, size(exact%panel) - 1
         if (place < from + exact%panel(panel) + merge(-same, same, behind)*exact%total) exit
         from = from + exact%panel(panel)
      end do
      x = 2*(place - from)/exact%panel(panel) - 1
   end subroutine locate

   !> No rotation at a node.
   pure subroutine hold(node, beside, side)
      integer, intent(in) :: node
      !> As in `solve_nodes`
      real(wp), intent(inout) :: beside(0:), side(0:)
      if (node > 0) beside(node - 1) = 0.0_wp
      beside(node) = 0.0_wp
      side(node) = 0.0_wp
   end subroutine hold

   !> Stiffness and load of a panel, the bubbles eliminated from the last to the first: their rows are left for going back.
   pure subroutine panel_matrix(exact, panel, lack, tension, value, slope, matrix, load)
      type(exact_type), intent(in) :: exact
      integer, intent(in) :: panel
      !> (stations)
      real(wp), intent(in) :: lack(:), tension(:)
      !> (fields, stations of a panel)
      real(wp), intent(in) :: value(:, :), slope(:, :)
      !> (fields, fields), (fields)
      real(wp), intent(out) :: matrix(:, :), load(:)
      real(wp) :: bend, pull, part
      integer :: i, j, k, m
      matrix = 0.0_wp
      load = 0.0_wp
      do j = 1, panel_stations
         k = panel_stations*(panel - 1) + j
         associate (ei => exact%section(of_ei, k), half => 0.5_wp*exact%panel(panel))
            bend = gauss_weight(j)*ei/half
            pull = gauss_weight(j)*half*(tension(k) + nearly_nothing*ei/exact%total**2)
            do i = 1, fields
               matrix(:, i) = matrix(:, i) + bend*slope(:, j)*slope(i, j) + pull*value(:, j)*value(i, j)
            end do
            load = load + gauss_weight(j)*ei*lack(k)*slope(:, j)
         end associate
      end do
      do m = fields, nodes + 1, -1
         do i = 1, m - 1
            part = matrix(i, m)/matrix(m, m)
            matrix(:m - 1, i) = matrix(:m - 1, i) - part*matrix(:m - 1, m)
            load(i) = load(i) - part*load(m)
         end do
      end do
   end subroutine panel_matrix

   !> Angles of the nodes from a matrix of three diagonals.
   pure subroutine solve_nodes(diagonal, beside, side)
      !> Of the matrix, and those beside, from node k to k + 1
      real(wp), intent(inout) :: diagonal(0:), beside(0:)
      !> Right-hand side, then the angles
      real(wp), intent(inout) :: side(0:)
      real(wp) :: part
      integer :: k
      do k = 1, ubound(side, 1)
         part = beside(k - 1)/diagonal(k - 1)
         diagonal(k) = diagonal(k) - part*beside(k - 1)
         side(k) = side(k) - part*side(k - 1)
      end do
      side(ubound(side, 1)) = side(ubound(side, 1))/diagonal(ubound(side, 1))
      do k = ubound(side, 1) - 1, 0, -1
         side(k) = (side(k) - beside(k)*side(k + 1))/diagonal(k)
      end do
   end subroutine solve_nodes

end module limber_beam_taut_axis
