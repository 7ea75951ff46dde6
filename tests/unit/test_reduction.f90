!> Axial bases and the reduction of a beam: what the functions span and hold, invariants against sums over the nodes, and how
!> many modes of each kind are the lowest.
program test_reduction
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_lapack, only: dgelsd
   use limber_flex_axial, only: axial_basis, element_functions, static_functions
   use limber_flex_geometric, only: element_ends, mean_slopes, mean_strains
   use limber_flex_mesh, only: axial_modes, beam_type, bending_modes, field_type, mesh_beam, new_support, nodal_masses, &
      & support_type
   use limber_flex_reduced, only: reduced_type, rigid_reduced
   use limber_flex_reduction, only: available_modes, axial_by_elements, axial_static, fidelity_full, fidelity_kg, &
      & fidelity_linear, point_shape, reduce_beam, reduction_type
   use scenes, only: derivative, random
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   type(beam_type), parameter :: rod = beam_type(ea=5.65e6_wp, ei=12.7_wp, rho_a=0.2225_wp, length=0.3_wp, elements=24)
   character(15), parameter :: names(7) = [character(15) :: 'PINNED-ROLLER', 'PINNED-PINNED', 'CLAMPED-FREE', &
      & 'CLAMPED-ROLLER', 'CLAMPED-PINNED', 'CLAMPED-CLAMPED', 'FREE-FREE']
   integer :: i

   do i = 1, size(names)
      call test_element_functions(trim(names(i)))
      call test_invariants(trim(names(i)))
   end do
   call test_static()
   call test_modal_derivatives()
   call test_dependent()
   call test_lowest()
   call test_too_many()
   call test_point_shape()
   call test_rigid()
   call finish()

contains

   !> One function for each k_G element: orthonormal in the lumped mass, stiffness diagonal, they hold every strain that the
   !> supports allow, and what is held stays.
   subroutine test_element_functions(name)
      character(*), intent(in) :: name
      integer, parameter :: parts = 6
      type(support_type) :: support
      type(field_type) :: field
      type(error_type), allocatable :: error
      real(wp) :: x(0:parts), mass(0:rod%elements), strain(parts), u(0:rod%elements), rest(0:rod%elements)
      real(wp), allocatable :: made(:, :), gram(:, :)
      integer :: n, i, j, g
      support = new_support(name)
      field = mesh_beam(rod)
      x = element_ends(rod%length, parts)
      call axial_basis(rod, support, x, element_functions(parts), field, made, error)
      call check_no_error(error, name)
      n = size(field%u, 2)
      call check(n == merge(parts - 1, parts, support%u_start .and. support%u_end), &
         & name//': one function for each element, less one where the length is held')
      call check(size(made, 2) == n .and. size(field%omega2_axial) == n, name//': strains and frequencies of each')
      mass = nodal_masses(rod)
      allocate (gram(n, n))
      do j = 1, n
         gram(:, j) = [(sum(mass*field%u(:, i)*field%u(:, j)), i=1, n)]
         gram(j, j) = gram(j, j) - 1.0_wp
      end do
      call check_close(maxval(abs(gram)), 0.0_wp, 1.0e-13_wp, name//': orthonormal in the lumped mass')
      do j = 1, n
         gram(:, j) = [(rod%ea*sum((x(1:) - x(:parts - 1))*made(:, i)*made(:, j)), i=1, n)]
         gram(j, j) = gram(j, j) - field%omega2_axial(j)
      end do
      call check_close(maxval(abs(gram))/maxval(field%omega2_axial), 0.0_wp, 1.0e-13_wp, name//': the stiffness is diagonal')
      call check(all(field%omega2_axial > 0.0_wp) .and. all(field%omega2_axial(2:) > field%omega2_axial(:n - 1)), &
         & name//': frequencies ascend')
      ! The k_G elements end at nodes: displacements and strains tell the same
      call check(maxval(abs(mean_strains(field, x) - made)) <= 1.0e-12_wp*maxval(abs(made)), name//': strains of the shapes')
      call check(.not. support%u_start .or. maxval(abs(field%u(0, :))) <= 1.0e-13_wp*maxval(abs(field%u)), name//': held start')
      call check(.not. support%u_end .or. maxval(abs(field%u(rod%elements, :))) <= 1.0e-13_wp*maxval(abs(field%u)), &
         & name//': held end')
      if (name == 'FREE-FREE') call check(maxval(abs(matmul(mass, field%u))) <= 1.0e-13_wp*sqrt(sum(mass)), &
         & name//': orthogonal to translation')
      call check(support%u_start .neqv. name == 'FREE-FREE', name//': only a free beam is free at its start')
      if (support%u_end) call check(maxval(abs(matmul(x(1:) - x(:parts - 1), made))) <= 1.0e-13_wp*rod%length*maxval(abs(made)), &
         & name//': no mean strain')

      ! Any allowed strain: its displacement less its projection on the basis is nothing
      strain = [(random(), g=1, parts)]
      if (support%u_end) strain = strain - sum(strain)/parts
      do i = 0, rod%elements
         u(i) = sum(strain*min(max(field%s(i) - x(0:parts - 1), 0.0_wp), x(1:) - x(0:parts - 1)))
      end do
      if (name == 'FREE-FREE') u = u - sum(mass*u)/sum(mass)
      rest = u - matmul(field%u, matmul(transpose(field%u), mass*u))
      call check(maxval(abs(rest)) <= 1.0e-12_wp*maxval(abs(u)), name//': the functions span the element strains')
   end subroutine test_element_functions

   !> The static functions solve their equations: EA u'' = 0 under an end force, EA u'' + (s - origin) p = 0 under the
   !> centrifugal load with a free end; in the mean over each k_G element.
   subroutine test_static()
      integer, parameter :: parts = 5
      real(wp), parameter :: origin = 0.07_wp
      real(wp) :: x(0:parts), none(0, 0, parts), exact, left, right
      real(wp), allocatable :: strain(:, :)
      integer :: g
      x = element_ends(rod%length, parts)
      strain = static_functions(x, none, origin, .true., .true., 3)
      call check(size(strain, 2) == 2, 'no derivatives without bending coordinates')
      call check(maxval(abs(strain(:, 1) - 1.0_wp)) <= 0.0_wp, 'an end force strains uniformly')
      do g = 1, parts
         ! tension at s: integral of (r - origin) from s to the end = ((L - o)^2 - (s - o)^2)/2; its mean over the element
         left = x(g - 1) - origin
         right = x(g) - origin
         exact = 0.5_wp*(rod%length - origin)**2 - (right**3 - left**3)/(6*(right - left))
         call check_close(strain(g, 2)*rod%length**2, exact, 1.0e-15_wp, 'mean tension of the centrifugal load')
      end do
      call check(size(static_functions(x, none, origin, .false., .true., 0), 2) == 1, 'the centrifugal load alone')
      call check(size(static_functions(x, none, origin, .false., .false., 0), 2) == 0, 'nothing at all')
   end subroutine test_static

   !> A modal derivative is the strain -B_ij/2 that lets the pair of modes bend without tension; a basis of them holds it.
   subroutine test_modal_derivatives()
      integer, parameter :: parts = 8, nb = 3
      type(field_type) :: field
      type(error_type), allocatable :: error
      type(reduction_type) :: choice
      type(reduced_type) :: body
      real(wp) :: x(0:parts), b(nb, nb, parts)
      real(wp), allocatable :: strain(:, :), a(:, :)
      integer :: pair, i, j, n
      x = element_ends(rod%length, parts)
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=nb, geometric_elements=parts, &
         & fidelity=fidelity_full, axial_basis=axial_static, end_force=.true., centrifugal=.true., derivatives=4)
      call reduce_beam(rod, choice, body, field, error)
      call check_no_error(error, 'modal derivatives')
      ! Slopes are cosines: (1,3) is a sum of (1,1), (2,2) and uniform strain
      call check(body%n - nb == 5, 'simply supported: the derivative (1,3) depends on the others')
      choice%support = new_support('CLAMPED-FREE')
      call reduce_beam(rod, choice, body, field, error)
      call check_no_error(error, 'modal derivatives')
      n = body%n - nb
      call check(n == 6, 'end force, centrifugal load and four derivatives')
      b = mean_slopes(field, x, .false.)
      strain = static_functions(x, b, 0.0_wp, .false., .false., 4)
      a = mean_strains(field, x)
      pair = 0
      do j = 1, nb
         do i = 1, j
            pair = pair + 1
            if (pair > 4) cycle
            call check(maxval(abs(strain(:, pair) + 0.5_wp*b(i, j, :))) <= 0.0_wp, 'derivatives in the order of the pairs')
            call check(remainder(a, strain(:, pair)) <= 1.0e-10_wp, 'the basis holds the derivative')
         end do
      end do
      call check(remainder(a, -0.5_wp*b(2, 3, :)) > 1.0e-4_wp, 'but not one that was not asked for')
      ! More pairs than there are: all of them
      call check(size(static_functions(x, b, 0.0_wp, .true., .true., 99), 2) == 8, 'at most all pairs')
   end subroutine test_modal_derivatives

   !> Norm of what the columns of a cannot hold of b, relative to b.
   real(wp) function remainder(a, b)
      real(wp), intent(in) :: a(:, :), b(:)
      real(wp) :: matrix(size(a, 1), size(a, 2)), unknown(size(a, 1), 1), values(size(a, 2)), work(4000)
      integer :: rank, info, integers(1000)
      matrix = a
      unknown(:, 1) = b
      call dgelsd(size(a, 1), size(a, 2), 1, matrix, size(a, 1), unknown, size(a, 1), values, 1.0e-12_wp, rank, work, size(work), &
         & integers, info)
      call check(info == 0 .and. rank == size(a, 2), 'the strains are independent')
      remainder = norm2(b - matmul(a, unknown(:size(a, 2), 1)))/norm2(b)
   end function remainder

   !> Functions that depend on those before them are left out, at any scale.
   subroutine test_dependent()
      integer, parameter :: parts = 4
      type(field_type) :: field
      type(error_type), allocatable :: error
      real(wp) :: x(0:parts), wanted(parts, 5)
      real(wp), allocatable :: made(:, :)
      x = element_ends(rod%length, parts)
      wanted(:, 1) = [1.0_wp, 2.0_wp, 0.0_wp, -1.0_wp]
      wanted(:, 2) = [1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp]
      wanted(:, 3) = 1.0e6_wp*wanted(:, 1) - 3.0e-2_wp*wanted(:, 2)
      wanted(:, 4) = 0.0_wp
      wanted(:, 5) = 1.0e-9_wp*[0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp]
      field = mesh_beam(rod)
      call axial_basis(rod, new_support('PINNED-ROLLER'), x, wanted, field, made, error)
      call check_no_error(error, 'dependent functions')
      call check(size(field%u, 2) == 3, 'dependent and empty functions are left out, small ones are not')
      field = mesh_beam(rod)
      call axial_basis(rod, new_support('PINNED-PINNED'), x, wanted, field, made, error)
      call check_no_error(error, 'dependent functions')
      call check(size(field%u, 2) == 2, 'uniform strain is nothing where the length is held')
      field = mesh_beam(rod)
      call axial_basis(rod, new_support('CLAMPED-CLAMPED'), [0.0_wp, rod%length], element_functions(1), field, made, error)
      call check_no_error(error, 'dependent functions')
      call check(size(field%u, 2) == 0 .and. size(made, 2) == 0, 'one element between two held ends has no function')
   end subroutine test_dependent

   !> Invariants against sums over the nodes written here; the coordinates are orthonormal in the mass as a whole.
   subroutine test_invariants(name)
      character(*), intent(in) :: name
      real(wp), parameter :: origin = 0.11_wp
      integer, parameter :: fidelities(3) = [fidelity_linear, fidelity_kg, fidelity_full]
      type(reduction_type) :: choice
      type(reduced_type) :: body
      type(field_type) :: field
      type(error_type), allocatable :: error
      real(wp), allocatable :: phi(:, :, :), mass(:)
      real(wp) :: product(3), p(2), own(7), scale
      integer :: basis, i, j, k
      do basis = 1, 3
         choice = reduction_type(support=new_support(name), bending=4, axial=3, geometric_elements=6, origin=origin, &
            & axial_basis=basis, fidelity=fidelities(basis))
         call reduce_beam(rod, choice, body, field, error)
         call check_no_error(error, name)
         call check(body%bending == 4 .and. body%n == 4 + size(field%u, 2), name//': number of coordinates')
         call check(body%geometric .eqv. basis > 1, name//': tension acts on the bending')
         call check(body%full .eqv. basis > 2, name//': the model full')
         allocate (phi(2, body%n, 0:rod%elements), mass(0:rod%elements))
         mass = rod%rho_a*rod%length/rod%elements
         mass([0, rod%elements]) = mass([0, rod%elements])/2
         phi = 0.0_wp
         phi(2, :4, :) = transpose(field%w)
         phi(1, 5:, :) = transpose(field%u)
         call check_close(body%mass, rod%rho_a*rod%length, 1.0e-15_wp, name//': mass')
         own(1) = sum(mass*(field%s - origin))
         call check(abs(body%c0(1) - own(1)) <= 1.0e-15_wp .and. abs(body%c0(2)) <= 0.0_wp, name//': first moment')
         call check_close(body%i0, sum(mass*(field%s - origin)**2), 1.0e-16_wp, name//': second moment')
         do j = 1, body%n
            own = 0.0_wp
            do i = 0, rod%elements
               p = [field%s(i) - origin, 0.0_wp]
               own(1:2) = own(1:2) + mass(i)*phi(:, j, i)
               own(3) = own(3) + mass(i)*dot_product(p, phi(:, j, i))
               own(4) = own(4) + mass(i)*(p(1)*phi(2, j, i) - p(2)*phi(1, j, i))
            end do
            scale = sqrt(body%mass)
            call check(maxval(abs(body%c(:, j) - own(1:2))) <= 1.0e-14_wp*scale, name//': C')
            call check(max(abs(body%d(j) - own(3)), abs(body%e(j) - own(4))) <= 1.0e-14_wp*scale*rod%length, name//': d and e')
            do k = 1, body%n
               product = 0.0_wp
               do i = 0, rod%elements
                  product(1) = product(1) + mass(i)*(phi(1, j, i)*phi(2, k, i) - phi(2, j, i)*phi(1, k, i))
                  product(2) = product(2) + mass(i)*dot_product(phi(:, j, i), phi(:, k, i))
               end do
               call check_close(body%skew(j, k), product(1), 1.0e-13_wp, name//': E')
               call check_close(product(2), merge(1.0_wp, 0.0_wp, j == k), 1.0e-11_wp, name//': D is the identity')
            end do
         end do
         call check(maxval(abs(body%skew(:4, 5:))) > 0.1_wp, name//': bending and axial coordinates couple')
         call check(maxval(abs(body%omega2 - [field%omega2_bending, field%omega2_axial])) <= 0.0_wp, name//': K_E')
         if (name == 'FREE-FREE') then
            call check(maxval(abs(body%c)) <= 1.0e-11_wp*sqrt(body%mass), name//': the centre of mass stays')
            call check(maxval(abs(body%e)) <= 1.0e-11_wp*sqrt(body%mass)*rod%length, name//': no angular momentum in the modes')
         end if
         deallocate (phi, mass)
      end do
   end subroutine test_invariants

   !> `modes` takes the lowest of both kinds together: for beams so stocky that they mix.
   subroutine test_lowest()
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(reduced_type) :: body
      type(field_type) :: field, all
      type(support_type) :: support
      type(error_type), allocatable :: error
      real(wp), allocatable :: omega2(:)
      integer :: modes, available(2), i, k
      do i = 1, size(names)
         support = new_support(trim(names(i)))
         beam = rod
         beam%elements = 7
         ! A radius of gyration of a sixteenth of the length: the second bending mode lies near the first axial one
         beam%ea = beam%ei*(16/beam%length)**2
         available = available_modes(beam, reduction_type(support=support))
         all = mesh_beam(beam)
         call bending_modes(beam, support, available(1), all, error)
         call check_no_error(error, names(i))
         call axial_modes(beam, support, available(2), all, error)
         call check_no_error(error, names(i))
         omega2 = sorted([all%omega2_bending, all%omega2_axial])
         do modes = 0, sum(available)
            choice = reduction_type(support=support, modes=modes, fidelity=fidelity_linear)
            call reduce_beam(beam, choice, body, field, error)
            call check_no_error(error, names(i))
            if (allocated(error)) cycle
            call check(body%n == modes, names(i)//': so many modes as asked for')
            call check(body%bending == count(all%omega2_bending <= omega2(max(1, modes))*(1 + 1.0e-9_wp)) .or. modes == 0, &
               & names(i)//': those in bending')
            call check(all_close(sorted(body%omega2), omega2(:modes)), names(i)//': they are the lowest')
         end do
         call check(any([(all%omega2_axial(1) < all%omega2_bending(k), k=1, 4)]), names(i)//': an axial mode among the lowest')
      end do
   end subroutine test_lowest

   pure logical function all_close(a, b)
      real(wp), intent(in) :: a(:), b(:)
      all_close = all(abs(a - b) <= 1.0e-9_wp*b)
   end function all_close

   pure function sorted(values) result(ascending)
      real(wp), intent(in) :: values(:)
      real(wp) :: ascending(size(values)), least
      integer :: i, j
      ascending = values
      do i = 1, size(values)
         j = i - 1 + minloc(ascending(i:), dim=1)
         least = ascending(j)
         ascending(j) = ascending(i)
         ascending(i) = least
      end do
   end function sorted

   !> Two elements, pinned and on a roller, have three modes; a fourth is an error that says so.
   subroutine test_too_many()
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(reduced_type) :: body
      type(field_type) :: field
      type(error_type), allocatable :: error
      beam = rod
      beam%elements = 2
      choice = reduction_type(support=new_support('PINNED-ROLLER'), modes=3)
      call reduce_beam(beam, choice, body, field, error)
      call check_no_error(error, 'three modes')
      call check(body%n == 3 .and. body%bending == 1, 'one bending and two axial modes')
      choice%modes = 4
      call reduce_beam(beam, choice, body, field, error)
      call check(allocated(error), 'a fourth mode is an error')
      if (allocated(error)) call check(index(error%message, 'gives 3 modes, 4 are asked for') > 0, 'the error has both numbers')
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=2, axial=1)
      call reduce_beam(beam, choice, body, field, error)
      call check(allocated(error), 'a second bending mode is an error')
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=1, axial=3)
      call reduce_beam(beam, choice, body, field, error)
      call check(allocated(error), 'a third axial mode is an error')
   end subroutine test_too_many

   !> Shapes of a point: those of the node it stands on, and a rotation that is the slope of the deflection.
   subroutine test_point_shape()
      type(reduction_type) :: choice
      type(reduced_type) :: body
      type(field_type) :: field
      type(error_type), allocatable :: error
      real(wp), allocatable :: phi(:, :), psi(:), value(:, :), turn(:)
      real(wp) :: x, h
      integer :: i, k
      choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=3, axial_basis=axial_by_elements, geometric_elements=4)
      call reduce_beam(rod, choice, body, field, error)
      call check_no_error(error, 'points')
      do i = 0, rod%elements
         call point_shape(field, field%s(i), phi, psi)
         call check(size(phi, 1) == 2 .and. size(phi, 2) == body%n .and. size(psi) == body%n, 'a column for each coordinate')
         call check(maxval(abs(phi(2, :3) - field%w(i, :))) <= 1.0e-13_wp*maxval(abs(field%w)), 'deflection of a node')
         call check(maxval(abs(phi(1, 4:) - field%u(i, :))) <= 1.0e-13_wp*maxval(abs(field%u)), 'extension of a node')
         call check(maxval(abs(psi(:3) - field%theta(i, :))) <= 1.0e-12_wp*maxval(abs(field%theta)), 'rotation of a node')
         call check(maxval(abs(phi(1, :3))) + maxval(abs(phi(2, 4:))) + maxval(abs(psi(4:))) <= 0.0_wp, &
            & 'bending moves across, axial coordinates along, and turn nothing')
      end do
      ! All places of the stencil lie in one element, where the deflection is a cubic
      x = 8.5_wp*rod%length/rod%elements
      h = 0.1_wp*rod%length/rod%elements
      allocate (value(body%n, -2:2))
      do k = -2, 2
         call point_shape(field, x + k*h, phi, turn)
         value(:, k) = phi(2, :)
      end do
      call point_shape(field, x, phi, psi)
      call check(maxval(abs(psi - derivative(value(:, -2), value(:, -1), value(:, 1), value(:, 2), h))) &
         & <= 1.0e-11_wp*maxval(abs(psi)), 'the rotation is the slope of the deflection')
   end subroutine test_point_shape

   !> A rigid body: Steiner.
   subroutine test_rigid()
      type(reduced_type) :: body
      body = rigid_reduced(3.0_wp, 0.5_wp, [2.0_wp, -1.0_wp])
      call check(body%n == 0 .and. body%bending == 0, 'a rigid body has no coordinates')
      call check_close(body%i0, 15.5_wp, 1.0e-14_wp, 'its moment about the origin')
      call check(maxval(abs(body%c0 - [6.0_wp, -3.0_wp])) <= 1.0e-15_wp, 'its first moment')
   end subroutine test_rigid

end program test_reduction
