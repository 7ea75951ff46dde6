!> Tangent of the equations of motion for implicit integrators. The derivatives of the equations of motion (mass M, damping D,
!> stiffness K), body by body, and the sparse matrix
!>
!>    [ m M + d D + k K    G^T ]
!>    [ G + g dG           0   ]
!>
!> with any real or complex factors. `limber_multibody_motion_residual` fills the blocks at an instant,
!> `limber_multibody_discrete_motion` over a step.
!> Floor: multibody. Source: doc/theory, eqs. (4.15), (4.16), (4.18), (4.34), (4.36).
module limber_multibody_tangent
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_model_model, only: ground
   use limber_multibody_compliant_constraints, only: refine
   use limber_multibody_sparse_matrix, only: sparse_type
   use limber_multibody_system, only: system_type, mark_block, block_place
   implicit none
   private
   public :: tangent_type, body_tangent_type, new_tangent, gather, combine, combine_complex, combine_stiffness, combine_values, &
      & add_block, factor_masses, solve_refined, give_way

   !> Derivatives of one body's equations (3 + n, 3 + n), and where they stand in the matrix
   type :: body_tangent_type
      real(wp), allocatable :: mass(:, :), damping(:, :), stiffness(:, :)
      integer, allocatable :: place(:, :)
   end type body_tangent_type

   !> Rows of a constraint on its two bodies, and where they stand
   type :: constraint_tangent_type
      !> Jacobian and its drift (rows, 3 + n) on either body
      real(wp), allocatable :: first(:, :), second(:, :), first_drift(:, :), second_drift(:, :)
      !> First and last column that is not zero always, on either body
      integer :: first_range(2) = 0, second_range(2) = 0
      !> Second derivatives across the two bodies; of no size if there are none
      real(wp), allocatable :: across(:, :)
      integer, allocatable :: first_place(:, :), second_place(:, :), first_transposed(:, :), second_transposed(:, :)
      integer, allocatable :: across_place(:, :), across_transposed(:, :)
   end type constraint_tangent_type

   !> Derivatives of minus the forces of a load (rates, rates), and where they stand
   type :: load_tangent_type
      real(wp), allocatable :: damping(:, :), stiffness(:, :)
      !> Unknowns of the load's two bodies, one after the other (rates), and places in the matrix
      integer, allocatable :: unknowns(:), place(:, :)
   end type load_tangent_type

   !> Derivatives of the whole system at one state
   type :: tangent_type
      type(sparse_type) :: matrix
      type(body_tangent_type), allocatable :: bodies(:)
      type(constraint_tangent_type), allocatable :: constraints(:)
      type(load_tangent_type), allocatable :: loads(:)
      !> The same gathered in the pattern of the matrix: M, D, K, G with its transpose, drift of G (entries, 5)
      real(wp), allocatable :: parts(:, :)
      !> Of redundant constraints: how much each gives way for a unit of `softness`, and places of the diagonal (nc; else of no
      !> size); how soft they are, as the step asks for it
      real(wp), allocatable :: slack(:)
      integer, allocatable :: slack_place(:)
      real(wp) :: softness = 0.0_wp
   contains
      procedure :: exchange => exchange_tangent
   end type tangent_type

contains

   !> Room and pattern.
   subroutine new_tangent(system, tangent)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(inout) :: tangent
      integer :: i, m, side
      allocate (tangent%bodies(size(system%layout%q)), tangent%constraints(size(system%constraints)))
      do i = 1, size(tangent%bodies)
         m = body_size(system, i)
         associate (body => tangent%bodies(i))
            allocate (body%mass(m, m), body%damping(m, m), body%stiffness(m, m))
            call mark_block(tangent%matrix, places(system, i), places(system, i))
         end associate
      end do
      do i = 1, size(tangent%constraints)
         associate (bodies => system%constraints(i)%item%bodies, constraint => tangent%constraints(i))
            call size_constraint(system, i, constraint)
            call mark_block(tangent%matrix, rows_of(system, i), part_of(system, bodies(1), constraint%first_range))
            call mark_block(tangent%matrix, rows_of(system, i), part_of(system, bodies(2), constraint%second_range))
            call mark_block(tangent%matrix, part_of(system, bodies(1), constraint%first_range), rows_of(system, i))
            call mark_block(tangent%matrix, part_of(system, bodies(2), constraint%second_range), rows_of(system, i))
            if (size(constraint%across) == 0) cycle
            call mark_block(tangent%matrix, places(system, bodies(1)), places(system, bodies(2)))
            call mark_block(tangent%matrix, places(system, bodies(2)), places(system, bodies(1)))
         end associate
      end do
      allocate (tangent%loads(size(system%loads)))
      do i = 1, size(tangent%loads)
         associate (item => system%loads(i)%item, load => tangent%loads(i))
            m = sum(item%rates)
            allocate (load%damping(m, m), load%stiffness(m, m))
            allocate (load%unknowns(m))
            do side = 1, size(item%bodies)
               load%unknowns(item%offsets(side) + 1:item%offsets(side) + item%rates(side)) = places(system, item%bodies(side))
            end do
            call mark_block(tangent%matrix, load%unknowns, load%unknowns)
         end associate
      end do
      call tangent%matrix%analyse(system%layout%nw + system%nc)
      allocate (tangent%matrix%complex_values(size(tangent%matrix%values)), tangent%parts(size(tangent%matrix%values), 5))
      call find_places(system, tangent)
      if (system%redundant) then
         allocate (tangent%slack, source=system%slack)
         allocate (tangent%slack_place(system%nc))
         do i = 1, system%nc
            tangent%slack_place(i) = tangent%matrix%place(system%layout%nw + i, system%layout%nw + i)
         end do
      else
         allocate (tangent%slack(0), tangent%slack_place(0))
      end if
   end subroutine new_tangent

   !> Room for the rows of a constraint, and the columns that they have: a joint that places a frame has only the frame's origin
   !> on its side, a driver only the rotation, so that the factors of what hangs or is driven cost nothing.
   subroutine size_constraint(system, i, constraint)
      type(system_type), intent(in) :: system
      !> Index of the constraint
      integer, intent(in) :: i
      type(constraint_tangent_type), intent(inout) :: constraint
      integer :: m, n
      associate (item => system%constraints(i)%item, tree => system%tree)
         m = body_size(system, item%bodies(1))
         n = body_size(system, item%bodies(2))
         allocate (constraint%first(item%rows, m), constraint%second(item%rows, n), constraint%first_drift(item%rows, m), &
            & constraint%second_drift(item%rows, n))
         constraint%first_range = [1, m]
         constraint%second_range = [1, n]
         if (tree%body(i) > 0) then
            if (tree%driver(tree%body(i)) == i) then
               constraint%first_range = [3, 3]
            else if (tree%joint(tree%body(i)) == i .and. tree%side(tree%body(i)) == 1) then
               constraint%first_range = [1, 2]
            else if (tree%joint(tree%body(i)) == i) then
               constraint%second_range = [1, 2]
            end if
         end if
         if (.not. item%couples()) then
            m = 0
            n = 0
         end if
         allocate (constraint%across(m, n))
      end associate
   end subroutine size_constraint

   !> Some of the unknowns of a body.
   pure function part_of(system, body, range) result(list)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body, range(2)
      integer :: list(range(2) - range(1) + 1), k
      if (body /= ground) list = [(system%layout%w(body) + k - 1, k=range(1), range(2))]
   end function part_of

   subroutine find_places(system, tangent)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(inout) :: tangent
      integer :: i
      do i = 1, size(tangent%bodies)
         tangent%bodies(i)%place = block_place(tangent%matrix, places(system, i), places(system, i))
      end do
      do i = 1, size(tangent%constraints)
         associate (c => tangent%constraints(i), bodies => system%constraints(i)%item%bodies, matrix => tangent%matrix)
            c%first_place = block_place(matrix, rows_of(system, i), part_of(system, bodies(1), c%first_range))
            c%second_place = block_place(matrix, rows_of(system, i), part_of(system, bodies(2), c%second_range))
            c%first_transposed = transpose(block_place(matrix, part_of(system, bodies(1), c%first_range), rows_of(system, i)))
            c%second_transposed = transpose(block_place(matrix, part_of(system, bodies(2), c%second_range), rows_of(system, i)))
            if (size(c%across) == 0) cycle
            c%across_place = block_place(matrix, places(system, bodies(1)), places(system, bodies(2)))
            c%across_transposed = transpose(block_place(matrix, places(system, bodies(2)), places(system, bodies(1))))
         end associate
      end do
      do i = 1, size(tangent%loads)
         tangent%loads(i)%place = block_place(tangent%matrix, tangent%loads(i)%unknowns, tangent%loads(i)%unknowns)
      end do
   end subroutine find_places

   !> Number of a body's rates; none of the ground.
   pure integer function body_size(system, body)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      body_size = 0
      if (body /= ground) body_size = system%layout%rates(body) + system%layout%n(body)
   end function body_size

   !> Unknowns of a body.
   pure function places(system, body) result(list)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      integer :: list(body_size(system, body)), k
      if (body /= ground) list = [(system%layout%w(body) + k - 1, k=1, size(list))]
   end function places

   !> Unknowns of a constraint's multipliers.
   pure function rows_of(system, constraint) result(list)
      type(system_type), intent(in) :: system
      integer, intent(in) :: constraint
      integer :: list(system%constraints(constraint)%item%rows), k
      list = [(system%layout%nw + system%constraints(constraint)%item%first + k - 1, k=1, size(list))]
   end function rows_of

   !> Gathers all derivatives in the pattern of the matrix.
   subroutine gather(tangent)
      type(tangent_type), intent(inout) :: tangent
      integer :: i
      tangent%parts = 0.0_wp
      associate (mass => tangent%parts(:, 1), damping => tangent%parts(:, 2), stiffness => tangent%parts(:, 3), &
         & rows => tangent%parts(:, 4), drift => tangent%parts(:, 5))
         do i = 1, size(tangent%bodies)
            associate (body => tangent%bodies(i))
               call add_block(body%place, body%mass, mass)
               call add_block(body%place, body%damping, damping)
               call add_block(body%place, body%stiffness, stiffness)
            end associate
         end do
         do i = 1, size(tangent%constraints)
            associate (c => tangent%constraints(i), a => tangent%constraints(i)%first_range(1), &
               & b => tangent%constraints(i)%first_range(2), d => tangent%constraints(i)%second_range(1), &
               & e => tangent%constraints(i)%second_range(2))
               call add_block(c%first_place, c%first(:, a:b), rows)
               call add_block(c%second_place, c%second(:, d:e), rows)
               call add_block(c%first_transposed, c%first(:, a:b), rows)
               call add_block(c%second_transposed, c%second(:, d:e), rows)
               call add_block(c%first_place, c%first_drift(:, a:b), drift)
               call add_block(c%second_place, c%second_drift(:, d:e), drift)
               if (size(c%across) == 0) cycle
               call add_block(c%across_place, c%across, stiffness)
               call add_block(c%across_transposed, c%across, stiffness)
            end associate
         end do
         do i = 1, size(tangent%loads)
            call add_block(tangent%loads(i)%place, tangent%loads(i)%damping, damping)
            call add_block(tangent%loads(i)%place, tangent%loads(i)%stiffness, stiffness)
         end do
      end associate
   end subroutine gather

   !> Adds a block to the entries of a matrix of this pattern.
   pure subroutine add_block(place, block, entries)
      !> Index of each entry of the block among all (rows, columns)
      integer, contiguous, intent(in) :: place(:, :)
      real(wp), contiguous, intent(in) :: block(:, :)
      real(wp), contiguous, intent(inout) :: entries(:)
      integer :: row, column
      do column = 1, size(block, 2)
         do row = 1, size(block, 1)
            entries(place(row, column)) = entries(place(row, column)) + block(row, column)
         end do
      end do
   end subroutine add_block

   !> Fills the matrix with real factors; `gather` comes first.
   pure subroutine combine(tangent, mass, damping, stiffness, drift)
      type(tangent_type), intent(inout) :: tangent
      !> Factors of M, D, K and of the drift of G
      real(wp), intent(in) :: mass, damping, stiffness, drift
      call combine_values(tangent, mass, damping, stiffness, drift, tangent%softness, tangent%matrix%values)
   end subroutine combine

   !> Fills the complex values of the matrix; `gather` comes first.
   pure subroutine combine_complex(tangent, mass, damping, stiffness, drift)
      type(tangent_type), intent(inout) :: tangent
      !> As in `combine`
      complex(wp), intent(in) :: mass, damping, stiffness, drift
      call add_complex(size(tangent%parts, 1), mass, damping, stiffness, drift, tangent%parts, tangent%matrix%complex_values)
      if (size(tangent%slack) == 0) return
      tangent%matrix%complex_values(tangent%slack_place) = tangent%matrix%complex_values(tangent%slack_place) &
         & - tangent%softness*tangent%slack
   end subroutine combine_complex

   !> Factors of the masses with the constraints; `gather` comes first.
   subroutine factor_masses(tangent, singular)
      type(tangent_type), intent(inout) :: tangent
      logical, intent(out) :: singular
      tangent%softness = 1.0_wp
      call combine(tangent, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
      call tangent%matrix%factor(singular)
   end subroutine factor_masses

   !> Fills the matrix with K - shift M; `gather` comes first.
   subroutine combine_stiffness(tangent, shift)
      type(tangent_type), intent(inout) :: tangent
      real(wp), intent(in) :: shift
      tangent%softness = static_softness(tangent)
      call combine(tangent, -shift, 0.0_wp, 1.0_wp, 0.0_wp)
   end subroutine combine_stiffness

   !> The values of the matrix with real factors, in a place of their own; `gather` comes first.
   pure subroutine combine_values(tangent, mass, damping, stiffness, drift, softness, values)
      type(tangent_type), intent(in) :: tangent
      !> Factors of M, D, K and of the drift of G; softness of redundant constraints
      real(wp), intent(in) :: mass, damping, stiffness, drift, softness
      !> (entries)
      real(wp), contiguous, intent(inout) :: values(:)
      call add_real(size(tangent%parts, 1), mass, damping, stiffness, drift, tangent%parts, values)
      if (size(tangent%slack) == 0) return
      values(tangent%slack_place) = values(tangent%slack_place) - softness*tangent%slack
   end subroutine combine_values

   !> The sum of the parts with real factors.
   pure subroutine add_real(entries, mass, damping, stiffness, drift, parts, values)
      integer, intent(in) :: entries
      real(wp), intent(in) :: mass, damping, stiffness, drift, parts(entries, 5)
      real(wp), intent(inout) :: values(entries)
      integer :: k
      do k = 1, entries
         values(k) = mass*parts(k, 1) + damping*parts(k, 2) + stiffness*parts(k, 3) + parts(k, 4) + drift*parts(k, 5)
      end do
   end subroutine add_real

   !> The same with complex factors.
   pure subroutine add_complex(entries, mass, damping, stiffness, drift, parts, values)
      integer, intent(in) :: entries
      complex(wp), intent(in) :: mass, damping, stiffness, drift
      real(wp), intent(in) :: parts(entries, 5)
      complex(wp), intent(inout) :: values(entries)
      integer :: k
      do k = 1, entries
         values(k) = cmplx(real(mass, wp)*parts(k, 1) + real(damping, wp)*parts(k, 2) + real(stiffness, wp)*parts(k, 3) &
            & + parts(k, 4) + real(drift, wp)*parts(k, 5), aimag(mass)*parts(k, 1) + aimag(damping)*parts(k, 2) &
            & + aimag(stiffness)*parts(k, 3) + aimag(drift)*parts(k, 5), wp)
      end do
   end subroutine add_complex

   !> Solves with the factors at hand. What redundant constraints give way is taken out again, eq. (4.34).
   subroutine solve_refined(tangent, nw, solution, correction)
      type(tangent_type), intent(inout) :: tangent
      !> Number of rates
      integer, intent(in) :: nw
      !> Right-hand side, then solution; scratch (nw + nc)
      real(wp), contiguous, intent(inout) :: solution(:), correction(:)
      call tangent%matrix%solve(solution)
      if (size(tangent%slack) > 0) call refine(tangent%matrix, nw, tangent%softness*tangent%slack, solution, correction)
   end subroutine solve_refined

   !> Softness of redundant constraints beside the stiffness instead of the mass: the ratio of the two.
   pure real(wp) function static_softness(tangent) result(softness)
      type(tangent_type), intent(in) :: tangent
      real(wp) :: stiffest
      softness = 1.0_wp
      if (size(tangent%slack) == 0) return
      stiffest = maxval(abs(tangent%parts(:, 3)))
      if (stiffest > 0.0_wp) softness = maxval(abs(tangent%parts(:, 1)))/stiffest
   end function static_softness

   !> Takes from the residual of the constraints what redundant ones give way under their multipliers, eq. (4.36).
   pure subroutine give_way(tangent, lambda, residual)
      type(tangent_type), intent(in) :: tangent
      !> Multipliers and residuals (nc)
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(inout) :: residual(:)
      integer :: i
      do i = 1, size(tangent%slack)
         residual(i) = residual(i) - tangent%softness*tangent%slack(i)*lambda(i)
      end do
   end subroutine give_way

   !> Saves or restores its memory.
   subroutine exchange_tangent(self, snapshot)
      class(tangent_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      call self%matrix%exchange(snapshot)
      if (.not. allocated(self%bodies)) return
      do i = 1, size(self%bodies)
         call snapshot%keep('mass', self%bodies(i)%mass)
         call snapshot%keep('damping', self%bodies(i)%damping)
         call snapshot%keep('stiffness', self%bodies(i)%stiffness)
      end do
      do i = 1, size(self%constraints)
         call snapshot%keep('first', self%constraints(i)%first)
         call snapshot%keep('second', self%constraints(i)%second)
         call snapshot%keep('first_drift', self%constraints(i)%first_drift)
         call snapshot%keep('second_drift', self%constraints(i)%second_drift)
         call snapshot%keep('across', self%constraints(i)%across)
      end do
      do i = 1, size(self%loads)
         call snapshot%keep('damping', self%loads(i)%damping)
         call snapshot%keep('stiffness', self%loads(i)%stiffness)
      end do
      call snapshot%keep('parts', self%parts)
      call snapshot%exchange('softness', self%softness)
      ! Not saved: slack, slack_place
   end subroutine exchange_tangent

end module limber_multibody_tangent
